#pragma once

#include <cstdint>

#include "ccvt/types.h"
#include "numbers.h"

namespace ccvt {

/// The points of this process, and their numbers among those of all ranks. A view.
template <class Scalar>
class OwnPoints {
 public:
  /// `first`: the number of the first among those of all.
  OwnPoints(const PointsView<Scalar>& points, std::int64_t first = 0)
      : points_(points), first_(first) {}

  [[nodiscard]] const PointsView<Scalar>& view() const { return points_; }
  [[nodiscard]] const Scalar* operator[](PointNumber point) const { return points_[point.index()]; }
  [[nodiscard]] const Scalar* operator[](PointOfAll point) const {
    return points_[own(point).index()];
  }

  [[nodiscard]] PointOfAll of_all(PointNumber point) const {
    return PointOfAll(first_ + point.index());
  }
  [[nodiscard]] PointNumber own(PointOfAll point) const {
    return PointNumber(point.index() - first_);
  }
  [[nodiscard]] bool has(PointOfAll point) const {
    return point.index() >= first_ && point.index() - first_ < points_.count;
  }

 private:
  PointsView<Scalar> points_;
  std::int64_t first_;
};

}  // namespace ccvt
