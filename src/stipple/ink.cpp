#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "ccvt/stipple.h"
#include "checks.h"
#include "geometry/as_matrix.h"
#include "number_text.h"

namespace ccvt {

namespace {

// Places of the raster: as many as there are in squares of a fifth of the radius, within limits.
constexpr double kPlacesPerSquaredRadius = 25;
constexpr double kFewestPlaces = 5e5;
constexpr double kMostPlaces = 8e6;
/// Covered places that make a measurement.
constexpr Eigen::Index kFewestCovered = 100;

struct Interval {
  double lower;
  double upper;
  [[nodiscard]] double length() const { return upper - lower; }
};

/// Where the dots are along one dimension, grown by `reach`, but not beyond the picture.
template <class Scalar>
Interval covered(PointsView<Scalar> dots, int dimension, double reach, double size) {
  const double least = as_matrix(dots).row(dimension).minCoeff();
  const double most = as_matrix(dots).row(dimension).maxCoeff();
  return {std::clamp(least - reach, 0.0, size), std::clamp(most + reach, 0.0, size)};
}

/// One dimension of a raster: the centres of equal steps over an interval.
class Axis {
 public:
  Axis(Interval interval, double step)
      : lower_(interval.lower),
        count_(std::ceil(interval.length() / step)),
        step_(interval.length() / count_),
        centres_(steps_to(count_)) {
    double steps = 0.5;
    for (double& centre : centres_) {
      centre = steps * step_;
      ++steps;
    }
  }

  [[nodiscard]] double lower() const { return lower_; }
  [[nodiscard]] double step() const { return step_; }
  /// From `lower` on.
  [[nodiscard]] const Eigen::ArrayXd& centres() const { return centres_; }

  struct Range {
    Eigen::Index first;
    Eigen::Index last;
  };
  /// All centres that are within `reach` of a place, and few more. Counted from `lower` on.
  [[nodiscard]] Range range(double place, double reach) const {
    return {steps_to((place - reach) / step_ - 0.5), steps_to((place + reach) / step_ + 1.5)};
  }

 private:
  [[nodiscard]] Eigen::Index steps_to(double end) const {
    return static_cast<Eigen::Index>(std::clamp(end, 0.0, count_));
  }

  double lower_;
  double count_;
  double step_;
  Eigen::ArrayXd centres_;
};

/// Places at the centres of a grid over a part of the picture, each with its squared distance to
/// the nearest dot.
class DistanceRaster {
 public:
  DistanceRaster(Interval x, Interval y, double step)
      : x_(x, step),
        y_(y, step),
        squared_(Eigen::ArrayXXf::Constant(x_.centres().size(), y_.centres().size(),
                                           std::numeric_limits<float>::infinity())) {}

  /// Places farther than `reach` from all dots stay at infinity.
  template <class Scalar>
  void measure(PointsView<Scalar> dots, double reach) {
    for (Index dot = 0; dot < dots.count; ++dot) {
      const double x = dots[dot][0] - x_.lower();
      const double y = dots[dot][1] - y_.lower();
      const auto [first_row, last_row] = y_.range(y, reach);
      for (Eigen::Index row = first_row; row < last_row; ++row) {
        const double dy = y_.centres()[row] - y;
        const double left = reach * reach - dy * dy;
        if (left < 0) continue;
        const auto [first, last] = x_.range(x, std::sqrt(left));
        const auto dx = x_.centres().segment(first, last - first) - x;
        auto places = squared_.col(row).segment(first, last - first);
        places = places.min((dx.square() + dy * dy).template cast<float>());
      }
    }
  }

  /// How many places stand for `area`.
  [[nodiscard]] Eigen::Index places(double area) const {
    return std::min<Eigen::Index>(std::lround(area / (x_.step() * y_.step())), squared_.size());
  }
  /// The squared distance of the place that is the `rank`-th nearest to a dot, from 1.
  double nth_squared(Eigen::Index rank) {
    float* const nth = squared_.data() + rank - 1;
    std::nth_element(squared_.data(), nth, squared_.data() + squared_.size());
    return *nth;
  }

 private:
  Axis x_;
  Axis y_;
  Eigen::ArrayXXf squared_;
};

}  // namespace

template <class Scalar>
double dot_radius_for(PointsView<Scalar> dots, int width, int height, double ink) {
  require_data("dots", dots);
  const double area = 1.0 * width * height;
  if (dots.dimension != 2 || dots.count < 1 || !as_matrix(dots).allFinite()) {
    throw InvalidInput("dots: must be finite, 2 by at least 1, but are " +
                       std::to_string(dots.dimension) + " by " + std::to_string(dots.count));
  }
  if (width < 1 || height < 1 || !(ink > 0 && ink <= area)) {
    throw InvalidInput("ink: is " + text(ink) + " for " + std::to_string(width) + " x " +
                       std::to_string(height) +
                       " pixels; must be positive and at most the number of pixels");
  }
  // Dots that do not overlap: no radius below this one covers enough.
  const double least = std::sqrt(ink / (std::numbers::pi * dots.count));
  const double beyond = 2 * std::hypot(width, height);  // of dots inside all places are nearer
  for (double reach = 1.5 * least; reach <= beyond; reach *= 2) {
    const Interval x = covered(dots, 0, reach, width);
    const Interval y = covered(dots, 1, reach, height);
    const double part = x.length() * y.length();
    if (!(part > 0)) return least;
    if (part < ink) continue;
    const double step =
        std::sqrt(part / std::clamp(kPlacesPerSquaredRadius * part / (least * least), kFewestPlaces,
                                    kMostPlaces));
    DistanceRaster raster(x, y, step);
    const Eigen::Index rank = raster.places(ink);
    if (rank < kFewestCovered) return least;
    raster.measure(dots, reach);
    const double squared = raster.nth_squared(rank);
    if (std::isfinite(squared)) return std::sqrt(squared);
  }
  return least;
}

template CCVT_EXPORT double dot_radius_for<float>(PointsView<float>, int, int, double);
template CCVT_EXPORT double dot_radius_for<double>(PointsView<double>, int, int, double);

}  // namespace ccvt
