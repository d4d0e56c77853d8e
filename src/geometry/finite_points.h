#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <string>

#include "ccvt/types.h"
#include "number_text.h"

namespace ccvt {

/// Throws InvalidInput unless all are finite; `is` is what they do, `first` the number of the
/// first.
template <class Matrix>
void require_finite(const Matrix& points, const char* is, std::int64_t first = 0) {
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    for (Eigen::Index d = 0; d < points.rows(); ++d) {
      if (std::isfinite(points(d, p))) continue;
      throw InvalidInput("points: coordinate " + std::to_string(d) + " of points[" +
                         std::to_string(first + p) + "] " + is + " " +
                         text(static_cast<double>(points(d, p))) + ": it must be finite");
    }
  }
}

}  // namespace ccvt
