#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "ccvt/types.h"
#include "io/input_file.h"
#include "io/text.h"

namespace ccvt::io {

/// Throws InvalidInput, which names `file`, the point and the coordinate, unless all are finite.
/// The first of the points is in row `first_row`.
template <class Scalar>
void check_finite(const InputFile& file, PointsView<Scalar> points, std::uint64_t first_row = 0) {
  for (Index row = 0; row < points.count; ++row) {
    for (int column = 0; column < points.dimension; ++column) {
      const Scalar x = points[row][column];
      if (std::isfinite(x)) continue;
      std::string text;
      append(text, x);
      file.fail("row " + std::to_string(first_row + static_cast<std::uint64_t>(row)) + ", column " +
                std::to_string(column) + ": " + text +
                " is not finite; coordinates must be finite");
    }
  }
}

}  // namespace ccvt::io
