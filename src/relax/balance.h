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
/// by potential(); the flow on an edge is phi_i - phi_j, rounded. Sites pass points on when
/// all that flow to them have arrived, on each edge those that want it most by the swap key. What
/// rounding leaves over is moved along a spanning tree, which makes capacities exact.
///
/// The graph is the Gabriel graph of the sites, taken from `near`, pairs of sites that are near
/// each other. Edges to farther sites would send points across other cells, and leave strays there.
/// Throws std::logic_error unless the surpluses sum to zero.
template <class Scalar>
void balance(const Metric& metric, const SiteState& sites, std::span<const Pair> near,
             const Arena& arena, Filling<Scalar>& filling);

}  // namespace ccvt
