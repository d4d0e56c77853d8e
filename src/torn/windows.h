#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "numbers.h"
#include "relax/site_state.h"
#include "spatial/site_tree.h"
#include "torn/torn_sites.h"

namespace ccvt {

/// Some sites, ascending, whose points are assigned anew.
using Window = std::vector<SiteNumber>;

struct WindowLimits {
  std::size_t sites;    ///< of a window
  std::int64_t points;  ///< of a window
  Index capacity;       ///< of a site in one
  double work;          ///< the sum of the squared numbers of sites of all windows, but the last
};

/// Windows around torn sites. Each has some of them, those that are nearest to their points, chains
/// of neighbours that link these, along which points can move from one to the other, and what lies
/// around, unless there is no room. Of up to 256 sites, if there is room, one has all. Windows
/// around the first of the torn sites come first. `tree`: of these sites.
std::vector<Window> windows_around(const SiteState& sites, const SiteTree& tree,
                                   std::span<const Index> capacities,
                                   std::span<const TornSite> torn, const WindowLimits& most);

}  // namespace ccvt
