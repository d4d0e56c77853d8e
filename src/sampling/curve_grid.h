#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "sampling/hilbert.h"

namespace ccvt {

/// A grid in a box around points, whose cells lie along a Hilbert curve. Its widest sides are
/// halved, so that cells are about as long as wide; sides without extent are not.
class CurveGrid {
 public:
  /// With `cells` cells or up to twice as many; one where the box is a point.
  CurveGrid(std::vector<double> lower, const std::vector<double>& upper, std::size_t cells)
      : lower_(std::move(lower)), shape_(lower_.size(), 1), cells_per_length_(lower_.size(), 0.0) {
    std::vector<double> side(lower_.size());  // of a cell
    for (std::size_t d = 0; d < side.size(); ++d) side[d] = upper[d] - lower_[d];
    for (; count_ < cells; count_ *= 2) {
      const auto widest = std::max_element(side.begin(), side.end());
      if (!(*widest > 0)) break;
      *widest /= 2;
      shape_[static_cast<std::size_t>(widest - side.begin())] *= 2;
    }
    for (std::size_t d = 0; d < side.size(); ++d) {
      const double inverse = 1 / side[d];
      if (shape_[d] > 1 && std::isfinite(inverse)) cells_per_length_[d] = inverse;
    }
  }

  [[nodiscard]] std::size_t count() const { return count_; }

  /// The nearest one of points outside.
  template <class Scalar>
  [[nodiscard]] std::size_t cell_of(const Scalar* x) const {
    std::size_t cell = 0;
    std::size_t stride = 1;
    for (std::size_t d = 0; d < shape_.size(); ++d) {
      if (shape_[d] == 1) continue;
      const auto last = static_cast<double>(shape_[d] - 1);
      const double along = (x[d] - lower_[d]) * cells_per_length_[d];
      cell += stride * static_cast<std::size_t>(std::clamp(along, 0.0, last));
      stride *= static_cast<std::size_t>(shape_[d]);
    }
    return cell;
  }

  /// Calls visit(cell) for each, in the order of the curve.
  template <class Visit>
  void visit_along_curve(const Visit& visit) const {
    HilbertCurve(shape_).visit([&](std::int64_t cell) { visit(static_cast<std::size_t>(cell)); });
  }

 private:
  std::vector<double> lower_;
  std::vector<std::int64_t> shape_;
  std::vector<double> cells_per_length_;  ///< along each side; 0 where it has one cell
  std::size_t count_ = 1;
};

}  // namespace ccvt
