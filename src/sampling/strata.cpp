#include "sampling/strata.h"

#include <cmath>

namespace ccvt {
namespace {

// Comparisons of results of exp() and log() leave this much room, so that the cuts do not hang on
// the last bits of the C library at hand.
constexpr double tolerance = 1e-9;

std::int64_t floor_robust(double x) { return static_cast<std::int64_t>(x + tolerance); }

// The divisor of `count` nearest to `ideal` within a factor 1.25, or 0 when there is none.
std::int64_t divisor_near(std::int64_t count, double ideal) {
  const std::int64_t low = floor_robust(std::ceil(ideal / 1.25 - tolerance));
  const std::int64_t high = floor_robust(ideal * 1.25);
  std::int64_t best = 0;
  double best_distance = 1;
  for (std::int64_t r = std::max(low, std::int64_t{1}); r <= high; ++r) {
    const double distance = std::abs(std::log(static_cast<double>(r) / ideal));
    if (count % r == 0 && distance < best_distance - tolerance) {
      best = r;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace

Strata::Strata(const Eigen::VectorXd& extent, std::int64_t count) : extent_(extent), count_(count) {
  std::vector<Eigen::Index> order;
  double remaining = 0;  // dimensions not yet cut
  for (Eigen::Index d = extent.size(); d-- > 0; ++remaining) order.push_back(d);
  // Stable, so that equal extents are cut from the last dimension to the first: cells of a cube are
  // numbered with the first dimension varying fastest.
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return extent[a] < extent[b]; });

  double log_volume = extent.array().log().sum();          // of the dimensions not yet cut
  double log_mean = std::log(static_cast<double>(count));  // mean number of points in a slab
  std::int64_t exact = count;                              // that number while it is whole, else 0
  for (std::size_t i = 0; i + 1 < order.size(); ++i, --remaining) {
    const double log_side = std::log(extent[order[i]]);
    const double ideal = std::exp(log_side + (log_mean - log_volume) / remaining);
    log_volume -= log_side;
    std::int64_t parts = exact > 0 ? divisor_near(exact, ideal) : 0;
    if (parts == 0) parts = std::max(floor_robust(ideal + 0.5), std::int64_t{1});
    if (parts == 1) continue;
    exact = exact % parts == 0 ? exact / parts : 0;
    log_mean -= std::log(static_cast<double>(parts));
    cuts_.push_back({order[i], parts});
  }
  cuts_.push_back({order.back(), 0});
}

}  // namespace ccvt
