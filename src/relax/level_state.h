#pragma once

#include "relax/cells.h"
#include "relax/site_state.h"
#include "schedule/tiling.h"

namespace ccvt {

/// The working tessellation of a level: whose the points are, and where the sites are. The solver
/// owns it; phases are handed it.
template <class Scalar>
struct LevelState {
  Tiling tiling;
  SiteState sites;
  Cells<Scalar> cells;
};

}  // namespace ccvt
