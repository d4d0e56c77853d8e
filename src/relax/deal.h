#pragma once

#include <span>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"
#include "geometry/metric.h"
#include "relax/cells.h"
#include "relax/site_state.h"

namespace ccvt {

/// The cheapest owners there are for all points, as a run that was cancelled ends with them: those
/// of the first filled[s] places of each cell stay, the others take a site with room, in two and
/// three dimensions one in the bin of a grid that they are in, as long as there is one. Sites own
/// as many points as `capacities` say. O(m); the sites stay where they are.
template <class Scalar>
std::vector<SiteNumber> deal_rest(const Metric& metric, const SiteState& sites, const Box& box,
                                  const PointsView<Scalar>& points,
                                  std::span<const Index> capacities, const Cells<Scalar>& cells,
                                  std::span<const Index> filled);

}  // namespace ccvt
