#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "numbers.h"
#include "parallel/arena.h"

namespace ccvt {

/// Up to so many sites are linked all together.
constexpr std::size_t kLinkedTogether = 8192;

/// All sites, at least one, in an order in which those near each other stand together. Up to
/// kLinkedTogether of them: every set that single linkage ever joins stands together, by the
/// minimum spanning tree [Prim 1957]. Of more, that holds in each of many small groups of near
/// sites, and of the groups' means. `sites`: positions of `dimension` values, one after the other.
/// O(n^2 D), and beyond that many sites O(n^1.5 D). Same for any number of threads.
std::vector<SiteNumber> linkage_order(std::span<const double> sites, int dimension,
                                      const Arena& arena);

}  // namespace ccvt
