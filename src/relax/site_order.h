#pragma once

#include <vector>

#include "parallel/arena.h"
#include "relax/site_state.h"

namespace ccvt {

/// Numbers sites anew so that those with consecutive numbers lie close together: recursive
/// bisection along the widest side, down to single sites. Parts are whole tiles of `tile_sites` as
/// long as they are larger, then powers of two, so that any 2^k consecutive sites from a multiple
/// of 2^k on are one part. Returns the sites in that order, by the numbers they have. O(n log n).
std::vector<SiteNumber> spatial_order(const SiteState& sites, Index tile_sites,
                                      const Arena& arena = Arena(1));

}  // namespace ccvt
