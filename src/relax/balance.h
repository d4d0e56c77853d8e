#pragma once

#include <span>

#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/filling.h"
#include "relax/site_state.h"
#include "schedule/schedule.h"

namespace ccvt {

/// Moves points between neighbouring sites until every cell is exactly full.
///
/// The surplus e of the sites flows down a potential: L phi = e on the graph of neighbours, solved
/// by potential(); the flow on an edge is phi_i - phi_j, rounded; on the edges of a spanning tree
/// it is what makes all flows together exact. Points then move along the edges in batches of pairs
/// of tiles, on each edge those that want it most by the swap key; a site with too few of them
/// passes the others on in a later round.
///
/// The graph is the Gabriel graph of the sites, taken from `near`, pairs of sites that are near
/// each other; of several ranks each gives those of its own sites. Edges to farther sites would
/// send points across other cells, and leave strays there. Throws std::logic_error unless the
/// surpluses sum to zero.
template <class Scalar>
void balance(const Metric& metric, const SiteState& sites, std::span<const Pair> near,
             const Arena& arena, Filling<Scalar>& filling);

}  // namespace ccvt
