#pragma once

#include <span>

#include "ccvt/metrics.h"

namespace ccvt {

/// Throws InvalidInput unless there is a set and all agree in dimension, count and domain.
void check_alike(std::span<const PointSet> sets);

/// Of radius r >= 0: V_D = V_{D-2} 2 pi r^2 / D. Not by std::lgamma(), which writes a global
/// variable.
double ball_volume(int dimension, double r);

}  // namespace ccvt
