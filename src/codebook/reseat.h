#pragma once

#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// Takes sites from where they are least missed to where they gain most: merges pairs of cells and
/// splits others in two, as long as splitting gains more than merging costs, no cell taking part
/// twice. What a merger costs is exact for the two cells [Ward 1963]; what a split gains is found
/// by 2-means in the cell. Points of these cells change owners with them. False when there is
/// nothing to gain. O(m D), and what cheapest_mergers() takes; divided among the arena's ranks,
/// which all have all points.
bool reseat_sites(PointsView<float> points, std::vector<Index>& owners, std::vector<double>& sites,
                  const Arena& arena = Arena(1));

}  // namespace ccvt
