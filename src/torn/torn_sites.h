#pragma once

#include <vector>

#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "relax/level_state.h"
#include "spatial/site_tree.h"

namespace ccvt {

/// A site whose cell is torn: its points cost over 1.3 times what they would at the sites nearest
/// to them, and a fifth of the mean energy of a cell more.
struct TornSite {
  SiteNumber site;
  double excess;                    ///< what its points cost more than at the sites nearest to them
  std::vector<SiteNumber> nearest;  ///< these sites, ascending
};

/// The torn sites of all ranks, those of the largest excess first, told from 64 points each. The
/// energies of all sites must be those of the points in their cells, and the radii bounds. `tree`:
/// of these sites.
///
/// O(n log n) in few dimensions, O(n^2) where SiteTree scans. Cells that do not reach as far as to
/// the next site are not looked into: of white points all but one in twelve with 16 points a site,
/// one in thirty with 64.
template <class Scalar>
std::vector<TornSite> torn_sites(const Metric& metric, const LevelState<Scalar>& state,
                                 const SiteTree& tree, const Arena& arena);

}  // namespace ccvt
