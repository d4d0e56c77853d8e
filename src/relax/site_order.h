#pragma once

#include <vector>

#include "ccvt/types.h"

namespace ccvt {

/// Numbers sites so that each run of `tile_sites` consecutive ones lies close together: recursive
/// bisection along the widest side, with whole tiles on both sides. Returns the sites in that
/// order. `positions`: #dimensions by n, one site after the other. O(n log n).
std::vector<Index> spatial_order(const std::vector<double>& positions, int dimension,
                                 Index tile_sites);

}  // namespace ccvt
