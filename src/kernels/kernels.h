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

/// The same on a torus for cells that fit in a common frame but cross the box's faces: to
/// coordinates below `turn`, their extent is added. See Metric::unrolled().
template <class Scalar>
struct WrappedCut {
  const Scalar* origin;
  const Scalar* normal;
  const Scalar* turn;
  const Scalar* extent;
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
  Scalar highest_i;
  Scalar lowest_j;
};

/// The highest key of a block of `count_i` >= 1 points and the lowest of one of `count_j` >= 1.
/// AnyCut is one of the three.
template <class Scalar, class AnyCut>
Extremes<Scalar> key_extremes(const Scalar* block_i, Index count_i, AnyCut cut_i,
                              const Scalar* block_j, Index count_j, AnyCut cut_j, int dimension);

/// The keys of a block of points.
template <class Scalar, class AnyCut>
void keys(const Scalar* block, Index count, int dimension, AnyCut cut, Scalar* out);

/// The places, ascending, of values above (below) a threshold; returns how many there are.
template <class Scalar>
Index places_above(const Scalar* values, Index count, Scalar threshold, Index* places);
template <class Scalar>
Index places_below(const Scalar* values, Index count, Scalar threshold, Index* places);

/// The sum of coordinates[k] - origin over one stream, in eight interleaved partial sums; of the
/// shortest differences on a torus when `extent` is not 0.
template <class Scalar>
double sum_from(const Scalar* stream, Index count, double origin, double extent);

struct Spread {
  double energy;          ///< sum of squared distances to the centre
  double squared_radius;  ///< largest squared distance to the centre
};

/// How a block is spread around `centre`; on a torus when `extent` is given.
template <class Scalar>
Spread spread_around(const Scalar* block, Index count, int dimension, const double* centre,
                     const double* extent);

}  // namespace ccvt::kernels
