#pragma once

#include <cstdint>
#include <vector>

#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/site_state.h"
#include "schedule/schedule.h"

namespace ccvt {

/// Whether gaining_pairs() is worth its cost in this domain.
bool screening_pays(const Metric& metric);

/// The pairs that may gain by an exchange, found by one blocked product of all points with all
/// sites. With M(i, j) the largest of |p - s_i|^2 - |p - s_j|^2 over the points p of cell i, the
/// pair (i, j) can gain only if M(i, j) + M(j, i) > 0. Rounding is allowed for, so that none is
/// missed. Pairs with neither site `touched` are left out. Sorted. O(m n D), divided among the
/// ranks that have the tiles.
template <class Scalar>
Buffer<Pair> gaining_pairs(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
                           const std::vector<std::uint8_t>& touched, const Tiling& tiling,
                           const Arena& arena);

}  // namespace ccvt
