#pragma once

#include "ccvt/types.h"

/// The loops over the points of a cell, compiled for each instruction set and chosen at run time.
/// A block holds one stream per dimension: coordinate d of point k is at block[d * count + k].
/// Results do not depend on the instruction set but for the last bits of keys, which their callers
/// treat as approximate.
namespace ccvt::kernels {

/// The hyperplane between two sites, as seen from one cell: key(p) = sum over d of
/// (p_d - middle_d) * normal_d. The larger its key, the more a point belongs to the site that the
/// normal points to.
template <class Scalar>
struct Cut {
  const Scalar* middle;
  const Scalar* normal;
};

/// The same on a torus for cells that have no common frame: key(p) = (|p - a|^2 - |p - b|^2) / 2
/// with wrapped differences. The larger the key, the more a point belongs to b.
template <class Scalar>
struct TorusCut {
  const Scalar* a;
  const Scalar* b;
  const Scalar* extent;
  const Scalar* inverse_extent;
};

template <class Scalar>
struct Extremes {
  Scalar lowest;
  Scalar highest;
};

/// The extreme keys of a block of `count` >= 1 points.
template <class Scalar>
Extremes<Scalar> key_extremes(const Scalar* block, Index count, int dimension, Cut<Scalar> cut);
template <class Scalar>
Extremes<Scalar> key_extremes(const Scalar* block, Index count, int dimension,
                              TorusCut<Scalar> cut);

/// The keys of a block of points.
template <class Scalar>
void keys(const Scalar* block, Index count, int dimension, Cut<Scalar> cut, Scalar* out);
template <class Scalar>
void keys(const Scalar* block, Index count, int dimension, TorusCut<Scalar> cut, Scalar* out);

/// The places, ascending, of values above (below) a threshold; returns how many there are.
template <class Scalar>
Index places_above(const Scalar* values, Index count, Scalar threshold, Index* places);
template <class Scalar>
Index places_below(const Scalar* values, Index count, Scalar threshold, Index* places);

/// The sums of coordinates[k] - origin over one stream, in eight interleaved partial sums.
template <class Scalar>
double sum_from(const Scalar* stream, Index count, double origin);

struct Spread {
  double energy;          ///< sum of squared distances to the centre
  double squared_radius;  ///< largest squared distance to the centre
};

/// How a block is spread around `centre` (Euclidean).
template <class Scalar>
Spread spread_around(const Scalar* block, Index count, int dimension, const double* centre);

/// The number of the position nearest to `query` (Euclidean), the first of several. `positions`:
/// `count` >= 1 of them, `dimension` values each, one after the other.
Index nearest_position(const double* query, const double* positions, Index count, int dimension);

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
