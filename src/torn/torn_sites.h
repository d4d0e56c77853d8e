#pragma once

#include <vector>

#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "relax/level_state.h"

namespace ccvt {

/// A site whose cell is torn: its points cost at least twice what they would at the sites nearest
/// to them, and half the mean energy of a cell more.
struct TornSite {
  SiteNumber site;
  double excess;                    ///< what its points cost more than at the sites nearest to them
  std::vector<SiteNumber> nearest;  ///< these sites, ascending
};

/// The torn sites of all ranks, those of the largest excess first, told from a few points each. The
/// energies of all sites must be those of the points in their cells.
///
/// O(n log n): cells whose points are close to their site, for what lies between it and the next
/// one, are not looked into.
template <class Scalar>
std::vector<TornSite> torn_sites(const Metric& metric, const LevelState<Scalar>& state,
                                 const Arena& arena);

}  // namespace ccvt
