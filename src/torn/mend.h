#pragma once

#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/level_state.h"
#include "torn/windows.h"

namespace ccvt {

/// Gives the points of a window the owners, and its sites the places, of a tessellation whose
/// assignment is optimal: as long as it pays, points are assigned to the sites by ExactAssignment,
/// and sites move to their centroids, in turn. False, and nothing changes, when the first
/// assignment gains less than a thousandth of the energy of the window. Sites have their energies
/// afterwards, but not their radii.
///
/// Ranks put the points of the window together, and each does all the rest. What it takes grows
/// with the square of the sites: .1 s for 512 sites of 64 points, of which hardly anything is done
/// in parallel.
template <class Scalar>
bool mend(const Metric& metric, const Window& window, LevelState<Scalar>& state,
          const Arena& arena);

}  // namespace ccvt
