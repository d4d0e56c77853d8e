#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "geometry/metric.h"
#include "numbers.h"
#include "relax/site_state.h"
#include "torn/torn_sites.h"

namespace ccvt {

/// Some sites, ascending, whose points are assigned anew.
using Window = std::vector<SiteNumber>;

/// Windows of at most so many sites. Each has torn sites, those that are nearest to their points,
/// chains of neighbours that link these, along which points can move from one to the other, and
/// what lies around. Each torn site is in one at least; of few sites, one has all.
///
/// O(n log n).
std::vector<Window> windows_around(const Metric& metric, const SiteState& sites,
                                   std::span<const TornSite> torn, std::size_t most);

}  // namespace ccvt
