#pragma once

#include <algorithm>

#include "ccvt/types.h"
#include "numbers.h"

namespace ccvt {

/// A copy of the points whose numbers are `chosen`, in that order.
template <class Scalar, class Numbers>
Points<Scalar> chosen_points(PointsView<Scalar> points, const Numbers& chosen) {
  Points<Scalar> copy(points.dimension, static_cast<Index>(chosen.size()));
  Index k = 0;
  for (const auto number : chosen) {
    std::copy_n(points[PointNumber(number).index()], points.dimension, copy.col(k++).data());
  }
  return copy;
}

}  // namespace ccvt
