#pragma once

#include <span>

#include "ccvt/metrics.h"

namespace ccvt {

/// Throws InvalidInput unless there is a set and all agree in dimension, count and domain.
void check_alike(std::span<const PointSet> sets);

}  // namespace ccvt
