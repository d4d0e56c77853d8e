#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "sampling/hilbert.h"

namespace ccvt {

/// A grid in a box around points, whose cells lie along a Hilbert curve. Its widest sides are
/// halved, so that cells are about as long as wide; sides without extent are not.
class CurveGrid {
 public:
  /// With `cells` cells or up to twice as many; one where the box is a point.
  CurveGrid(const std::vector<double>& lower, const std::vector<double>& upper, std::size_t cells)
      : shape_(lower.size(), 1) {
    std::vector<double> side(lower.size());  // of a cell
    for (std::size_t d = 0; d < side.size(); ++d) side[d] = upper[d] - lower[d];
    for (; count_ < cells; count_ *= 2) {
      const auto widest = std::max_element(side.begin(), side.end());
      if (!(*widest > 0)) break;
      *widest /= 2;
      shape_[static_cast<std::size_t>(widest - side.begin())] *= 2;
    }
    std::int64_t stride = 1;
    for (std::size_t d = 0; d < side.size(); ++d) {
      const double inverse = 1 / side[d];
      if (shape_[d] > 1 && std::isfinite(inverse)) {
        axes_.push_back({d, stride, lower[d], inverse, static_cast<double>(shape_[d] - 1)});
      }
      stride *= shape_[d];
    }
  }

  [[nodiscard]] std::size_t count() const { return count_; }

  /// The nearest one of points outside.
  template <class Scalar>
  [[nodiscard]] std::size_t cell_of(const Scalar* x) const {
    std::int64_t cell = 0;
    for (const Axis& axis : axes_) {
      const double along = (x[axis.dimension] - axis.lower) * axis.cells_per_length;
      cell += axis.stride * static_cast<std::int64_t>(std::clamp(along, 0.0, axis.last));
    }
    return static_cast<std::size_t>(cell);
  }

  /// Calls visit(cell) for each, in the order of the curve.
  template <class Visit>
  void visit_along_curve(const Visit& visit) const {
    HilbertCurve(shape_).visit([&](std::int64_t cell) { visit(static_cast<std::size_t>(cell)); });
  }

 private:
  /// Along which there is more than one cell.
  struct Axis {
    std::size_t dimension;
    std::int64_t stride;
    double lower;
    double cells_per_length;
    double last;  ///< cell
  };
  std::vector<Axis> axes_;
  std::vector<std::int64_t> shape_;
  std::size_t count_ = 1;
};

}  // namespace ccvt
