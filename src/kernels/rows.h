#pragma once

#include "ccvt/types.h"

namespace ccvt::kernels {

/// centred_rows() takes so many points at a time.
constexpr Index kRowGroup = 8;

/// Points that lie anywhere, as streams: (rows[k][d] - centre[d]) * scale, taken in double, as
/// block[d * stride + k] for k < width, a multiple of kRowGroup. There are `count` >= 1 rows, and
/// the last in place of those that are missing.
template <class Scalar>
void centred_rows(const Scalar* const* rows, Index count, Index width, int dimension,
                  const double* centre, double scale, float* block, Index stride);

/// The same numbers one point after the other: block[k * dimension + d] for k < count.
void centred_points(const double* const* rows, Index count, int dimension, const double* centre,
                    double scale, float* block);

/// sum[d] += rows[k][d] - centre[d], in double, for one row after the other: the same bits for any
/// instruction set.
template <class Scalar>
void add_rows(const Scalar* const* rows, Index count, int dimension, const double* centre,
              double* sum);

}  // namespace ccvt::kernels
