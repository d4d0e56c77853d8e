#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "ccvt/stipple.h"
#include "geometry/as_matrix.h"

namespace ccvt {

namespace {

// Places of the raster: as many as there are in squares of a fifth of the radius, within limits.
constexpr double kPlacesPerSquaredRadius = 25;
constexpr double kFewestPlaces = 5e5;
constexpr double kMostPlaces = 8e6;
/// Covered places that make a measurement.
constexpr double kFewestCovered = 100;

struct Interval {
  double lower;
  double upper;
  [[nodiscard]] double length() const { return upper - lower; }
};

/// Where the dots are along one dimension, grown by `reach`, but not beyond the picture.
template <class Scalar>
Interval covered(PointsView<Scalar> dots, int dimension, double reach, int size) {
  const auto least = static_cast<double>(as_matrix(dots).row(dimension).minCoeff());
  const auto most = static_cast<double>(as_matrix(dots).row(dimension).maxCoeff());
  return {std::clamp(least - reach, 0.0, static_cast<double>(size)),
          std::clamp(most + reach, 0.0, static_cast<double>(size))};
}

/// Places at the centres of a grid over a part of the picture, each with its squared distance to
/// the nearest dot.
class DistanceRaster {
 public:
  DistanceRaster(Interval x, Interval y, double step)
      : x_(x),
        y_(y),
        columns_(static_cast<std::size_t>(std::ceil(x.length() / step))),
        rows_(static_cast<std::size_t>(std::ceil(y.length() / step))),
        step_x_(x.length() / static_cast<double>(columns_)),
        step_y_(y.length() / static_cast<double>(rows_)),
        squared_(columns_ * rows_, std::numeric_limits<float>::infinity()) {}

  /// Places farther than `reach` from all dots stay at infinity.
  template <class Scalar>
  void measure(PointsView<Scalar> dots, double reach) {
    for (Index dot = 0; dot < dots.count; ++dot) {
      const double x = static_cast<double>(dots[dot][0]) - x_.lower;
      const double y = static_cast<double>(dots[dot][1]) - y_.lower;
      const auto [first_row, last_row] = range(y, reach, step_y_, rows_);
      for (std::size_t row = first_row; row < last_row; ++row) {
        const double dy = (static_cast<double>(row) + 0.5) * step_y_ - y;
        const double left = reach * reach - dy * dy;
        if (left < 0) continue;
        const auto [first, last] = range(x, std::sqrt(left), step_x_, columns_);
        float* const places = squared_.data() + row * columns_;
        for (std::size_t column = first; column < last; ++column) {
          const double dx = (static_cast<double>(column) + 0.5) * step_x_ - x;
          places[column] = std::min(places[column], static_cast<float>(dx * dx + dy * dy));
        }
      }
    }
  }

  /// How many places stand for `area`.
  [[nodiscard]] double places(double area) const {
    return std::min(std::round(area / (step_x_ * step_y_)), static_cast<double>(squared_.size()));
  }
  /// The squared distance of the place that is the `rank`-th nearest to a dot, from 1.
  double nth_squared(double rank) {
    const auto nth = squared_.begin() + static_cast<std::ptrdiff_t>(rank) - 1;
    std::nth_element(squared_.begin(), nth, squared_.end());
    return static_cast<double>(*nth);
  }

 private:
  struct Range {
    std::size_t first;
    std::size_t last;
  };
  static Range range(double centre, double reach, double step, std::size_t count) {
    const auto limit = static_cast<double>(count);
    return {static_cast<std::size_t>(std::clamp((centre - reach) / step - 0.5, 0.0, limit)),
            static_cast<std::size_t>(std::clamp((centre + reach) / step + 1.5, 0.0, limit))};
  }

  Interval x_;
  Interval y_;
  std::size_t columns_;
  std::size_t rows_;
  double step_x_;
  double step_y_;
  std::vector<float> squared_;
};

}  // namespace

template <class Scalar>
double dot_radius_for(PointsView<Scalar> dots, int width, int height, double ink) {
  const double area = static_cast<double>(width) * height;
  if (dots.dimension != 2 || dots.count < 1 || !as_matrix(dots).allFinite()) {
    throw InvalidInput("dots: must be finite, 2 by at least 1, but are " +
                       std::to_string(dots.dimension) + " by " + std::to_string(dots.count));
  }
  if (width < 1 || height < 1 || !(ink > 0 && ink <= area)) {
    throw InvalidInput("ink: is " + std::to_string(ink) + " for " + std::to_string(width) + " x " +
                       std::to_string(height) +
                       " pixels; must be positive and at most the number of pixels");
  }
  // Dots that do not overlap: no radius below this one covers enough.
  const double least = std::sqrt(ink / (std::numbers::pi * dots.count));
  for (double reach = 1.5 * least;; reach *= 2) {
    const Interval x = covered(dots, 0, reach, width);
    const Interval y = covered(dots, 1, reach, height);
    const double part = x.length() * y.length();
    if (!(part > 0)) return least;
    if (part < ink) continue;
    const double step =
        std::sqrt(part / std::clamp(kPlacesPerSquaredRadius * part / (least * least), kFewestPlaces,
                                    kMostPlaces));
    DistanceRaster raster(x, y, step);
    const double rank = raster.places(ink);
    if (rank < kFewestCovered) return least;
    raster.measure(dots, reach);
    const double squared = raster.nth_squared(rank);
    if (std::isfinite(squared)) return std::sqrt(squared);
  }
}

template CCVT_EXPORT double dot_radius_for<float>(PointsView<float>, int, int, double);
template CCVT_EXPORT double dot_radius_for<double>(PointsView<double>, int, int, double);

}  // namespace ccvt
