#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "ccvt/metrics.h"
#include "metrics/sets.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "random.h"
#include "streams.h"
#include "thread_count.h"

namespace ccvt {

namespace {

constexpr int kPlaces = 256;

/// The integral over a unit interval of exp(-(x - c)^2 / (2 s^2)).
double gaussian_integral(double c, double s) {
  const double scale = 1 / (s * std::numbers::sqrt2);
  return s * std::sqrt(std::numbers::pi / 2) * (std::erf((1 - c) * scale) + std::erf(c * scale));
}

/// What one function at one place gives.
struct Trial {
  double squared_error = 0;
  double variance = 0;  ///< of the function
};

/// The three functions at one random place, uniform in the unit cube.
class Functions {
 public:
  Functions(bool periodic, int dimension, Random& random)
      : periodic_(periodic), c_(dimension), disk_volume_(ball_volume(dimension, kRadius)) {
    for (double& x : c_) x = random.uniform();
    axis_ = random.below(static_cast<std::uint64_t>(dimension));
    disk_ = c_;
    if (!periodic_) disk_ = (kRadius + (1 - 2 * kRadius) * c_.array()).matrix();
  }

  std::array<Trial, 3> evaluate(const Points<double>& points) const {
    std::array<double, 3> sum{};
    for (Eigen::Index p = 0; p < points.cols(); ++p) {
      double to_centre = 0;
      double to_disk = 0;
      for (Eigen::Index d = 0; d < points.rows(); ++d) {
        to_centre += squared(points(d, p) - c_[d]);
        to_disk += squared(points(d, p) - disk_[d]);
      }
      sum[0] += std::exp(-to_centre / (2 * kDeviation * kDeviation));
      sum[1] += to_disk < kRadius * kRadius ? 1 : 0;
      sum[2] += in_step(points.col(p).data()[axis_]) ? 1 : 0;
    }
    const std::array<double, 3> integral = {gaussian(kDeviation), disk_volume_,
                                            periodic_ ? 0.5 : c_.data()[axis_]};
    const std::array<double, 3> integral_of_square = {gaussian(kDeviation / std::numbers::sqrt2),
                                                      integral[1], integral[2]};
    const double count = view_points(points).count;
    std::array<Trial, 3> trials;
    for (std::size_t f = 0; f < 3; ++f) {
      const double error = sum[f] / count - integral[f];
      trials[f] = {error * error, integral_of_square[f] - integral[f] * integral[f]};
    }
    return trials;
  }

 private:
  static constexpr double kDeviation = 1.0 / 8;
  static constexpr double kRadius = 1.0 / 4;

  [[nodiscard]] double squared(double difference) const {
    if (periodic_) difference -= std::round(difference);
    return difference * difference;
  }
  [[nodiscard]] bool in_step(double x) const {
    const double behind = x - c_.data()[axis_];
    return periodic_ ? behind - std::floor(behind) < 0.5 : behind < 0;
  }
  [[nodiscard]] double gaussian(double s) const {
    double product = 1;
    for (const double c : c_) product *= gaussian_integral(periodic_ ? 0.5 : c, s);
    return product;
  }

  bool periodic_;
  Eigen::VectorXd c_;
  double disk_volume_;
  std::uint64_t axis_ = 0;
  Eigen::VectorXd disk_;
};

}  // namespace

IntegrationVariance integration_variance(const PointSet& set, std::uint64_t seed, int threads) {
  require_points(set);
  require_threads(threads);
  return integration_variance(set, seed, Arena(threads));
}

IntegrationVariance integration_variance(const PointSet& set, std::uint64_t seed,
                                         const Arena& arena) {
  const Points<double> points = in_unit_cube(set);
  std::vector<std::array<Trial, 3>> trials(kPlaces);
  arena.for_each(trials.size(), 1, [&](std::size_t place) {
    Random random(seed, streams::integration_places + place);
    const Functions functions(set.domain().is_periodic(), set.dimension(), random);
    trials[place] = functions.evaluate(points);
  });
  std::array<Trial, 3> sum{};
  for (const auto& place : trials) {
    for (std::size_t f = 0; f < 3; ++f) {
      sum[f].squared_error += place[f].squared_error;
      sum[f].variance += place[f].variance;
    }
  }
  const auto ratio = [&](const Trial& t) { return t.squared_error / t.variance * set.count(); };
  return {ratio(sum[0]), ratio(sum[1]), ratio(sum[2])};
}

}  // namespace ccvt
