#pragma once

#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "relax/level_state.h"
#include "torn/windows.h"

namespace ccvt {

/// What a window was before it was mended: the points of this rank, cell after cell, and all sites.
template <class Scalar>
struct Unmended {
  Window window;
  std::vector<PointOfAll> number;
  std::vector<Scalar> coordinates;
  std::vector<double> sites;
  std::vector<double> radius;
  std::vector<double> energy;
};

/// Gives the points of a window the owners, and its sites the places, of a tessellation whose
/// assignment is optimal: as long as it pays, points are assigned to the sites by ExactAssignment,
/// and sites move to their centroids, in turn. What that gains: nothing, and nothing changes, when
/// it would be less than two thousandths of the energy of the window by the first assignment. Sites
/// have their energies afterwards, and radii without bound. `undo` gets what the window was.
///
/// Ranks put the points of the window together, and each does all the rest. What it takes grows
/// with the square of the sites: .1 s for 512 sites of 64 points, of which hardly anything is done
/// in parallel.
template <class Scalar>
double mend(const Metric& metric, const Window& window, LevelState<Scalar>& state,
            const Arena& arena, std::vector<Unmended<Scalar>>& undo);

/// All windows as they were, of which nothing is left in `undo`.
template <class Scalar>
void restore(std::vector<Unmended<Scalar>>& undo, LevelState<Scalar>& state);

}  // namespace ccvt
