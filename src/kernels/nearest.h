#pragma once

#include <cstdint>

#include "ccvt/types.h"

namespace ccvt::kernels {

/// The number of the position nearest to `query`, the first of several; on a torus when `extent`
/// is given. `positions`: `count` >= 1 of them, `dimension` values each, one after the other.
Index nearest_position(const double* query, const double* positions, Index count, int dimension,
                       const double* extent);

/// The stride of nearest_positions() is a multiple of this.
constexpr Index kNearestPoints = 16;

/// For each of `stride` points the number of the position nearest to it, the first of several, in
/// two or three dimensions. `points`: a stream for each dimension, one every `stride` values.
/// `positions`: `count` >= 1 of them, `dimension` values each, one after the other.
void nearest_positions(const double* points, Index stride, int dimension, const double* positions,
                       Index count, std::int32_t* nearest);

/// Positions in a pack: coordinate d of its k-th is at [d * kPack + k].
constexpr Index kPack = 8;

/// The squared distances from `query` to the positions of `packs` consecutive packs; on a torus
/// when `extent` is given.
void squared_distances(const double* query, const double* positions, Index packs, int dimension,
                       const double* extent, double* out);

/// The same bits for each of `count` queries, in out[k] for the k-th: positions are read once for
/// several.
void squared_distances(const double* const* queries, Index count, const double* positions,
                       Index packs, int dimension, const double* extent, double* const* out);

/// The squared distances from `query` to `count` points of `dimension` values each: bit for bit
/// squared_difference() of geometry/squares.h.
template <class Scalar>
void squared_distances_of(const Scalar* const* points, Index count, int dimension,
                          const double* query, double* out);

}  // namespace ccvt::kernels
