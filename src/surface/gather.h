#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {

/// Points that are owned by a site whose points are mostly of another group are given to sites of
/// their own, the nearest that have room when such points have left. Capacities stay, but where a
/// group has more such points than room: some of its sites then get one more, and some of other
/// groups are left with fewer. Does nothing where that would be more than one for each site.
template <class Scalar>
void gather_groups(PointsView<Scalar> points, PointsView<Scalar> sites,
                   std::span<const Index> groups, std::vector<Index>& owners);

}  // namespace ccvt
