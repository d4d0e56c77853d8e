#pragma once

#include <algorithm>

#include "ccvt/problem.h"
#include "geometry/coordinate_range.h"

namespace ccvt {

/// The problem's box, or the smallest around its points.
template <class Scalar>
Box bounding_box(const Problem<Scalar>& problem, const Arena& arena) {
  return problem.domain().has_box() ? problem.domain().box() : box_around(problem.points(), arena);
}

/// On the absolute values of all coordinates in it.
inline double largest_coordinate(const Box& box) {
  return std::max(box.lower.eigen().cwiseAbs().maxCoeff(), box.upper.eigen().cwiseAbs().maxCoeff());
}

}  // namespace ccvt
