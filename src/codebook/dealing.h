#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// Owners that keep the capacities, which sum to the number of points. In rounds: every point that
/// has no owner yet is to go to the nearest site with room, and a site that more want than there is
/// room for takes those nearest to it. Once rounds get on slowly, the rest go one by one. `sites`:
/// positions, one after the other. O(m n D), and as much for a round or for the rest; by blocked
/// products but for the rest.
template <class Scalar>
std::vector<Index> deal_to_nearest(PointsView<Scalar> points, std::span<const double> sites,
                                   std::span<const Index> capacities, const Arena& arena);

}  // namespace ccvt
