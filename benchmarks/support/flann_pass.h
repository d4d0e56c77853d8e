#pragma once

#include "ccvt/types.h"

namespace ccvt::bench {

/// The yardstick: the seconds that it takes FLANN, on one thread, to build a k-d tree of the first
/// `sites` points and to find the nearest of them to every point, exactly. Euclidean.
double flann_pass(PointsView<float> points, Index sites);

}  // namespace ccvt::bench
