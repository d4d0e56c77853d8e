#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "ccvt/domain.h"

namespace ccvt {

/// The shortest of the differences that `difference`, of two coordinates in the box, stands for on
/// a torus. Without branches, so that loops over it are vectorized.
inline double shortest_difference(double difference, double extent) {
  const double turn = std::abs(difference) > extent / 2 ? std::copysign(extent, difference) : 0.0;
  return difference - turn;
}

/// Its absolute value, in fewer operations; for differences of at most one extent.
inline double shortest_distance(double difference, double extent) {
  const double one_way = std::abs(difference);
  return std::min(one_way, extent - one_way);
}

/// Squared distances in the domain. Euclidean when `extent` is empty, else on the torus.
class Metric {
 public:
  Metric(int dimension, const Domain& domain) : dimension_(dimension) {
    if (!domain.is_periodic()) return;
    const Box& box = domain.box();
    lower_.assign(box.lower.begin(), box.lower.end());
    const Eigen::VectorXd extent = box.extent();
    extent_.assign(extent.begin(), extent.end());
    largest_extent_ = extent.maxCoeff();
  }

  [[nodiscard]] int dimension() const { return dimension_; }
  [[nodiscard]] bool periodic() const { return !extent_.empty(); }
  [[nodiscard]] const double* extent() const { return extent_.data(); }
  [[nodiscard]] const double* lower() const { return lower_.data(); }
  /// 0 when Euclidean.
  [[nodiscard]] double largest_extent() const { return largest_extent_; }

  /// The shortest of the differences that `difference`, of two positions in the box, stands for.
  [[nodiscard]] double wrap(double difference, int d) const {
    return periodic() ? shortest_difference(difference, extent_[static_cast<std::size_t>(d)])
                      : difference;
  }

  /// Whether, along dimension d, what is no farther than `radius` from a coordinate in the box may
  /// lie beyond its faces; also when it nearly does, as rounding must not decide.
  [[nodiscard]] bool reaches_face(double x, double radius, int d) const {
    const auto k = static_cast<std::size_t>(d);
    const double from_lower = x - lower_[k];
    const double room = radius + 1e-9 * extent_[k];
    return std::min(from_lower, extent_[k] - from_lower) < room;
  }

  /// How to take shortest differences to `middle` without wrapping them: x - middle, wrapped, is
  /// x - origin, and one extent more where x < turn; for x in the box, and half an extent or less
  /// between it and `middle`.
  struct Unrolled {
    double origin;
    double turn;
  };
  [[nodiscard]] Unrolled unrolled(double middle, int d) const {
    const auto k = static_cast<std::size_t>(d);
    const double half = extent_[k] / 2;
    if (middle < lower_[k] + half) return {middle + extent_[k], middle + half};
    return {middle, middle - half};
  }

  /// Moves a coordinate into [lower, upper).
  [[nodiscard]] double into_box(double x, int d) const {
    if (!periodic()) return x;
    const auto k = static_cast<std::size_t>(d);
    const double y = x - extent_[k] * std::floor((x - lower_[k]) / extent_[k]);
    return y < lower_[k] + extent_[k] && y >= lower_[k] ? y : lower_[k];
  }

  /// A coordinate in [lower, upper) as a Scalar that still is.
  template <class Scalar>
  [[nodiscard]] Scalar as(double x, int d) const {
    const auto y = static_cast<Scalar>(x);
    if (!periodic()) return y;
    const auto k = static_cast<std::size_t>(d);
    constexpr auto infinity = std::numeric_limits<Scalar>::infinity();
    if (static_cast<double>(y) >= lower_[k] + extent_[k]) return std::nextafter(y, -infinity);
    return static_cast<double>(y) < lower_[k] ? std::nextafter(y, infinity) : y;
  }

  template <class A, class B>
  [[nodiscard]] double squared_distance(const A* a, const B* b) const {
    if (dimension_ == 2) return squared_distance_in<2>(a, b);
    if (dimension_ == 3) return squared_distance_in<3>(a, b);
    return squared_distance_in<0>(a, b);
  }

 private:
  /// `Dimension`: 0 for any. Where it is known, the loop is unrolled.
  template <int Dimension, class A, class B>
  [[nodiscard]] double squared_distance_in(const A* a, const B* b) const {
    const double* const extent = periodic() ? extent_.data() : nullptr;
    double sum = 0;
    for (int d = 0; d < (Dimension > 0 ? Dimension : dimension_); ++d) {
      const double difference = static_cast<double>(a[d]) - static_cast<double>(b[d]);
      const double distance =
          extent != nullptr ? shortest_distance(difference, extent[d]) : difference;
      sum += distance * distance;
    }
    return sum;
  }

  int dimension_ = 0;
  std::vector<double> lower_;
  std::vector<double> extent_;
  double largest_extent_ = 0;
};

}  // namespace ccvt
