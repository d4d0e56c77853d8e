#pragma once

/// The whole library.
#include "ccvt/build_info.h"     // IWYU pragma: export
#include "ccvt/capacity.h"       // IWYU pragma: export
#include "ccvt/codebook.h"       // IWYU pragma: export
#include "ccvt/density.h"        // IWYU pragma: export
#include "ccvt/domain.h"         // IWYU pragma: export
#include "ccvt/grid_values.h"    // IWYU pragma: export
#include "ccvt/io.h"             // IWYU pragma: export
#include "ccvt/linear_map.h"     // IWYU pragma: export
#include "ccvt/lloyd.h"          // IWYU pragma: export
#include "ccvt/mapped_points.h"  // IWYU pragma: export
#include "ccvt/metrics.h"        // IWYU pragma: export
#include "ccvt/options.h"        // IWYU pragma: export
#include "ccvt/particles.h"      // IWYU pragma: export
#include "ccvt/point_cloud.h"    // IWYU pragma: export
#include "ccvt/presets.h"        // IWYU pragma: export
#include "ccvt/problem.h"        // IWYU pragma: export
#include "ccvt/publication.h"    // IWYU pragma: export
#include "ccvt/region.h"         // IWYU pragma: export
#include "ccvt/sampling.h"       // IWYU pragma: export
#include "ccvt/solver.h"         // IWYU pragma: export
#include "ccvt/stipple.h"        // IWYU pragma: export
#include "ccvt/summary.h"        // IWYU pragma: export
#include "ccvt/surface.h"        // IWYU pragma: export
#include "ccvt/tessellation.h"   // IWYU pragma: export
#include "ccvt/thin.h"           // IWYU pragma: export
#include "ccvt/types.h"          // IWYU pragma: export
#include "ccvt/volume.h"         // IWYU pragma: export
#include "ccvt/weighted.h"       // IWYU pragma: export
