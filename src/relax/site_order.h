#pragma once

#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// Numbers sites so that those with consecutive numbers lie close together: recursive bisection
/// along the widest side, down to single sites. Parts are whole tiles of `tile_sites` as long as
/// they are larger, then powers of two, so that any 2^k consecutive sites from a multiple of 2^k on
/// are one part. Returns the sites in that order. `positions`: #dimensions by n, one site after the
/// other. O(n log n).
std::vector<Index> spatial_order(const std::vector<double>& positions, int dimension,
                                 Index tile_sites, const Arena& arena = Arena(1));

}  // namespace ccvt
