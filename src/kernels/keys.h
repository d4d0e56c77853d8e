#pragma once

#include "ccvt/types.h"

/// The loops over the points of a cell, compiled for each instruction set and chosen at run time.
/// A block holds one stream per dimension: coordinate d of point k is at block[d * count + k].
/// Keys may differ in their last bits from one instruction set to another, and their callers treat
/// them as approximate; those of keys() do not.
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

/// The same where the cells cross faces in the one dimension `across`, the only one in which
/// `origin` is not the middle: `jump` is the extent times the normal there, added to the keys of
/// points whose coordinate is below `turn`.
template <class Scalar>
struct FaceCut {
  const Scalar* origin;
  const Scalar* normal;
  Scalar turn;
  Scalar jump;
  int across;
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
/// AnyCut is one of the four.
template <class Scalar, class AnyCut>
Extremes<Scalar> key_extremes(const Scalar* block_i, Index count_i, const AnyCut& cut_i,
                              const Scalar* block_j, Index count_j, const AnyCut& cut_j,
                              int dimension);

enum class Beyond { above, below };

/// The highest key, or the lowest, of `count` >= 1 points of a block, of which `block` is the
/// first, and whose streams are `stride` apart.
template <class Scalar, class AnyCut>
Scalar extreme_key(const Scalar* block, Index stride, Index count, int dimension, const AnyCut& cut,
                   Beyond beyond);

/// The keys of a block of points. The library asks for those of Cut and WrappedCut only, tests for
/// all.
template <class Scalar, class AnyCut>
void keys(const Scalar* block, Index count, int dimension, const AnyCut& cut, Scalar* out);

/// The places, ascending, of the points whose keys are above, or below, a threshold, of `count`
/// points of a block as above; returns how many. `places` has room for all of them.
template <class Scalar, class AnyCut>
Index places_beyond(const Scalar* block, Index stride, Index count, int dimension,
                    const AnyCut& cut, Beyond beyond, Scalar threshold, Index* places);

}  // namespace ccvt::kernels
