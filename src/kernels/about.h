#pragma once

#include "ccvt/types.h"

namespace ccvt::kernels {

/// The squared distances from each of `queries` queries to `count` points of `dimension` values
/// each, in float, for what only looks for the nearest: that from the q-th to the k-th point is
/// out[q * stride + k]. Where no square is too large or too small for float, it is off by a share
/// of (dimension + 3) epsilons of float at most.
void about_squared_distances_of(const float* const* points, Index count, int dimension,
                                const float* const* query, Index queries, float* out, Index stride);

/// Positions in a pack of floats: coordinate d of its k-th is at [d * kFloatPack + k].
constexpr Index kFloatPack = 64;

/// The same from `query` to the positions of consecutive packs; its bits do not depend on the
/// instruction set.
void about_squared_distances(const float* query, const float* positions, Index packs, int dimension,
                             float* out);

}  // namespace ccvt::kernels
