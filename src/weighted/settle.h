#pragma once

#include "relax/site_graph.h"
#include "weighted/mass_cells.h"

namespace ccvt {

/// Moves points between neighbouring cells until the mass of each differs from its capacity by less
/// than MassCells::error_bound(). No point is heavier than any capacity.
///
/// Let B be the bound and e what a cell is too heavy by; all e sum to 0. First cells with e >= B
/// push: along the shortest paths to the nearest cells with e < 0, the roots, each gives its parent
/// points, until its e is below B; a root takes points only while its e < 0. A point weighs at most
/// B, so a cell that gives keeps e >= 0, and a root that takes keeps e < B: neither becomes what it
/// was not. What a round leaves too heavy has a root that has no room left: it is no root in the
/// next one. So there are at most n rounds, and after the last one no e is B or more: when there is
/// no root any more all e >= 0, and as they sum to 0 they are 0. Then cells with e <= -B pull in
/// the same way from the nearest ones with e > 0. A cell that is asked for a point and has none
/// pulls first: then its e > -B, and as its capacity is no less than B it has some. Pulling makes
/// no e larger than before or than 0. Rounding: B is a little below the mass of the heaviest point,
/// and what is called 0 above a little less than that.
///
/// O(rounds * edges + points that move * points of a cell).
template <class Scalar>
void settle(MassCells<Scalar>& cells, const SiteGraph& graph);

}  // namespace ccvt
