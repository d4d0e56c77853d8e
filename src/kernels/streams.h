#pragma once

#include "ccvt/types.h"

/// The loops over the points of a cell, compiled for each instruction set and chosen at run time.
/// A block holds one stream per dimension: coordinate d of point k is at block[d * count + k].
/// Results do not depend on the instruction set.
namespace ccvt::kernels {

template <class Scalar>
struct Range {
  Scalar low;
  Scalar high;
};

/// The least and the greatest of `count` >= 1 coordinates.
template <class Scalar>
Range<Scalar> range(const Scalar* stream, Index count);

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
