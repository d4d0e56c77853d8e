#pragma once

#include "ccvt/types.h"

namespace ccvt::kernels {

/// A site as points see it: the power distance of a point q to it is |q|^2 + offset - q . slope.
/// All are relative to one origin.
///
/// `slopes`: of each of `count` sites, `dimension` values; `offsets`: one of each.
template <class Scalar>
struct PowerSites {
  const Scalar* slopes;
  const Scalar* offsets;
  Index count;
};

/// What nearest_powers() finds: the nearest site, the next, and how much farther it is. With one
/// site only, the next is the same, and infinitely far.
template <class Scalar>
struct NearestPowers {
  Index* nearest;
  Index* next;
  Scalar* margin;
};

/// For each of `count` points the two sites that are nearest to it by power distance; of equal ones
/// the first. `points`: a stream for each dimension, one every `stride` values. Bits do not depend
/// on the instruction set.
template <class Scalar>
void nearest_powers(const Scalar* points, Index stride, Index count, int dimension,
                    const PowerSites<Scalar>& sites, const NearestPowers<Scalar>& out);

/// The places, ascending, of the points to which a site is nearer than the first one, or less than
/// `width` farther; returns how many. `places` has room for all.
template <class Scalar>
Index contested_places(const Scalar* points, Index stride, Index count, int dimension,
                       const PowerSites<Scalar>& sites, Scalar width, Index* places);

}  // namespace ccvt::kernels
