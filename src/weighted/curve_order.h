#pragma once

#include <vector>

#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/arena.h"

namespace ccvt {

/// `which` of the points in an order in which what stands together lies together: along the Hilbert
/// curve of a grid of about a cell a point, and in crowded cells along curves of their own, of a
/// grid in the box around their points. Any number of dimensions; where there are more than grids
/// have bits, the widest sides are divided. O(points * dimensions) unless they crowd.
template <class Scalar>
std::vector<PointNumber> curve_order(PointsView<Scalar> points, std::vector<PointNumber> which,
                                     const Arena& arena);

}  // namespace ccvt
