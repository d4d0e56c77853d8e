#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <vector>

#include "ccvt/domain.h"
#include "geometry/torus.h"

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

/// Squared distances in the domain. Euclidean when `extent` is empty, else on its torus, see
/// torus_of().
class Metric {
 public:
  Metric(int dimension, const Domain& domain) : dimension_(dimension) {
    if (!domain.is_periodic()) return;
    const Box box = torus_of(domain);
    lower_.assign(box.lower.begin(), box.lower.end());
    const Eigen::VectorXd extent = box.extent();
    extent_.assign(extent.begin(), extent.end());
    largest_extent_ = extent.maxCoeff();
  }

  [[nodiscard]] int dimension() const { return dimension_; }
  /// The dimension, as the size of what has a number for each.
  [[nodiscard]] std::size_t coordinate_count() const {
    return static_cast<std::size_t>(dimension_);
  }
  [[nodiscard]] bool periodic() const { return !extent_.empty(); }
  [[nodiscard]] const double* extent() const { return extent_.data(); }
  [[nodiscard]] const double* lower() const { return lower_.data(); }
  /// 0 when Euclidean.
  [[nodiscard]] double largest_extent() const { return largest_extent_; }

  /// The shortest of the differences that `difference`, of two positions in the box, stands for.
  [[nodiscard]] double wrap(double difference, std::integral auto d) const {
    return periodic() ? shortest_difference(difference, extent()[d]) : difference;
  }

  /// Whether, along dimension d, what is no farther than `radius` from a coordinate in the box may
  /// lie beyond its faces; also when it nearly does, as rounding must not decide.
  [[nodiscard]] bool reaches_face(double x, double radius, std::integral auto d) const {
    const double from_lower = x - lower()[d];
    const double room = radius + 1e-9 * extent()[d];
    return std::min(from_lower, extent()[d] - from_lower) < room;
  }

  /// How to take shortest differences to `middle` without wrapping them: x - middle, wrapped, is
  /// x - origin, and one extent more where x < turn; for x in the box, and half an extent or less
  /// between it and `middle`.
  struct Unrolled {
    double origin;
    double turn;
  };
  [[nodiscard]] Unrolled unrolled(double middle, std::integral auto d) const {
    const double half = extent()[d] / 2;
    if (middle < lower()[d] + half) return {middle + extent()[d], middle + half};
    return {middle, middle - half};
  }

  /// Moves a coordinate into [lower, upper).
  [[nodiscard]] double into_box(double x, std::integral auto d) const {
    if (!periodic()) return x;
    const double low = lower()[d];
    const double whole = extent()[d];
    const double y = x - whole * std::floor((x - low) / whole);
    return y < low + whole && y >= low ? y : low;
  }

  /// A coordinate in [lower, upper) as a Scalar that still is.
  template <class Scalar>
  [[nodiscard]] Scalar as(double x, std::integral auto d) const {
    const auto y = static_cast<Scalar>(x);
    if (!periodic()) return y;
    constexpr auto infinity = std::numeric_limits<Scalar>::infinity();
    if (y >= lower()[d] + extent()[d]) return std::nextafter(y, -infinity);
    return y < lower()[d] ? std::nextafter(y, infinity) : y;
  }

  template <class A, class B>
  [[nodiscard]] double squared_distance(const A* a, const B* b) const {
    if (dimension_ == 2) return squared_distance_in<2>(a, b);
    if (dimension_ == 3) return squared_distance_in<3>(a, b);
    return squared_distance_in<0>(a, b);
  }

  /// The same of positions that may lie outside the box, and mean their images in it.
  template <class A, class B>
  [[nodiscard]] double squared_distance_of_images(const A* a, const B* b) const {
    double sum = 0;
    for (std::size_t d = 0; d < coordinate_count(); ++d) {
      const double to = a[d];
      double difference = to - b[d];
      if (periodic()) {
        if (std::abs(difference) > extent()[d]) {
          difference = std::remainder(difference, extent()[d]);
        }
        difference = shortest_distance(difference, extent()[d]);
      }
      sum += difference * difference;
    }
    return sum;
  }

 private:
  /// `Dimension`: 0 for any. Where it is known, the loop is unrolled.
  template <int Dimension, class A, class B>
  [[nodiscard]] double squared_distance_in(const A* a, const B* b) const {
    const double* const extent = periodic() ? extent_.data() : nullptr;
    double sum = 0;
    for (int d = 0; d < (Dimension > 0 ? Dimension : dimension_); ++d) {
      const double to = a[d];
      const double difference = to - b[d];
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
