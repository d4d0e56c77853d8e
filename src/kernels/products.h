#pragma once

#include "ccvt/types.h"

/// Products of a block of points with many sites, compiled for each instruction set and chosen at
/// run time. A block holds one stream per dimension: coordinate d of point k is at
/// block[d * stride + k], where `stride` is a multiple of product_points(). Multiplications and
/// additions may fuse: callers allow for rounding.
namespace ccvt::kernels {

/// Sites of a call of site_costs() come in multiples of this.
constexpr Index kCostSites = 6;
Index product_points();

/// cost[j * stride + k] = constant[j] - x_k . v_j for each point k and each of `sites` sites
/// (`dimension` values each in v, one site after the other); lowest[k] falls to the least of them.
void site_costs(const float* block, Index stride, int dimension, const float* v,
                const float* constant, Index sites, float* cost, float* lowest);

/// The places (row * stride + k) of costs that are not above limit[k], row by row, ascending;
/// returns how many there are. `places` has room for rows * stride.
Index costs_within(const float* cost, Index stride, Index rows, const float* limit, Index* places);

/// least[row] = the least of the costs of each row.
void least_costs(const float* cost, Index stride, Index rows, float* least);

/// squared[k] = |x_k - q|^2 where that is less than squared[k].
void lower_squares(const float* block, Index stride, int dimension, const float* q, float* squared);

/// Of kSumPoints points at a time, the sum of min(squared[k], |x_k - q|^2): what lower_squares()
/// would leave; the last of fewer, where `count` is no multiple.
constexpr Index kSumPoints = 64;
void lowered_sums(const float* block, Index stride, Index count, int dimension, const float* q,
                  const float* squared, double* sums);

/// For each of `sites` sites (a multiple of kDotSites, `dimension` values each, one after the
/// other) the largest over the points of (point . site) - offset[point]. `block` has `stride`
/// points (a multiple of dot_points<Scalar>()). The inner loop of a matrix product, without the
/// product.
template <class Scalar>
void largest_dots(const Scalar* block, Index stride, int dimension, const Scalar* offset,
                  const Scalar* sites, Index site_count, Scalar* largest);
constexpr Index kDotSites = 6;
template <class Scalar>
Index dot_points();

}  // namespace ccvt::kernels
