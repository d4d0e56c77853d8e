#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/metrics.h"
#include "geometry/metric.h"
#include "metrics/sets.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "spatial/site_tree.h"
#include "thread_count.h"

namespace ccvt {

namespace {

constexpr std::size_t kChunk = 256;  ///< points a task; fixed, as sums are made by chunk

/// The numbers `begin` to `end` - 1.
NumberRange<PointNumber> point_range(std::size_t begin, std::size_t end) {
  return {PointNumber(begin), PointNumber(end)};
}

/// Adds to bins, which reach up to `radius`, the pairs (p, q), p in `chunk`, p != q.
void count_pairs(const PointSet& set, const Metric& metric, const SiteTree& tree, double bin,
                 double radius, NumberRange<PointNumber> chunk, std::vector<double>& bins) {
  const auto& points = set.points();
  const Eigen::VectorXd extent = set.domain().box().extent();
  std::vector<Index> found;
  for (const PointNumber p : chunk) {
    const double* const at = points.col(p.index()).data();
    found.clear();
    tree.within(at, radius, found);
    for (const Index q : found) {
      if (q == p.index()) continue;
      const double distance = std::sqrt(metric.squared_distance(at, points.col(q).data()));
      const auto k = static_cast<std::size_t>(distance / bin);
      if (k >= bins.size()) continue;
      double weight = 1;
      if (!metric.periodic()) {
        for (int d = 0; d < set.dimension(); ++d) {
          weight /= 1 - std::abs(at[d] - points(d, q)) / extent[d];
        }
      }
      bins[k] += weight;
    }
  }
}

}  // namespace

double ball_volume(int dimension, double r) {
  double volume = dimension % 2 == 0 ? 1 : 2 * r;
  for (int d = dimension % 2 == 0 ? 2 : 3; d <= dimension; d += 2) {
    volume *= 2 * std::acos(-1.0) * r * r / d;
  }
  return volume;
}

double packing_distance(int dimension) {
  if (dimension < 1) {
    throw InvalidInput("dimension: " + std::to_string(dimension) + " is not positive");
  }
  static const std::array<double, 8> center_density = {
      1.0 / 2,                   // Z
      1 / (2 * std::sqrt(3.0)),  // hexagonal
      1 / (4 * std::sqrt(2.0)),  // face-centred cubic
      1.0 / 8,                   // D4
      1 / (8 * std::sqrt(2.0)),  // D5
      1 / (8 * std::sqrt(3.0)),  // E6
      1.0 / 16,                  // E7
      1.0 / 16};                 // E8
  if (dimension > 8) return std::sqrt(2.0);
  return 2 * std::pow(center_density.data()[dimension - 1], 1.0 / dimension);
}

NearestDistances nearest_distances(const PointSet& set, int threads) {
  require_points(set);
  require_threads(threads);
  return nearest_distances(set, Arena(threads));
}

NearestDistances nearest_distances(const PointSet& set, const Arena& arena) {
  const Metric metric(set.dimension(), set.domain());
  const SiteTree tree(metric, coordinates_of(set));
  std::vector<double> distance(static_cast<std::size_t>(set.count()));
  arena.for_ranges(distance.size(), kChunk, [&](std::size_t begin, std::size_t end, int) {
    std::vector<Index> found;
    for (const PointNumber p : point_range(begin, end)) {
      const double* const at = set.points().col(p.index()).data();
      found.clear();
      tree.nearest(at, 2, found);
      double squared = std::numeric_limits<double>::infinity();
      for (const Index q : found) {
        if (q == p.index()) continue;
        squared = std::min(squared, metric.squared_distance(at, set.points().col(q).data()));
      }
      distance[p] = std::sqrt(squared);
    }
  });
  NearestDistances result{std::numeric_limits<double>::infinity(), 0};
  for (const double d : distance) {
    result.smallest = std::min(result.smallest, d);
    result.mean += d;
  }
  const double unit = packing_distance(set.dimension()) * set.mean_spacing();
  result.smallest /= unit;
  result.mean /= unit * set.count();
  return result;
}

PairCorrelation pair_correlation(std::span<const PointSet> sets, int threads) {
  require_threads(threads);
  return pair_correlation(sets, Arena(threads));
}

PairCorrelation pair_correlation(std::span<const PointSet> sets, const Arena& arena) {
  check_alike(sets);
  const PointSet& first = sets.front();
  const double reach = first.domain().box().extent().minCoeff() / 2 / first.mean_spacing();
  PairCorrelation result;
  result.bin_width = 1.0 / 16;
  const double bins = std::floor(std::min(4.0, reach) / result.bin_width * (1 + 1e-12));
  result.value.assign(static_cast<std::size_t>(bins), 0.0);
  if (result.value.empty()) return result;
  const Metric metric(first.dimension(), first.domain());
  const auto count = static_cast<std::size_t>(first.count());
  // Independent points have n (n - 1) |shell| / |box| ordered pairs in a shell; |box| is n in mean
  // spacings.
  double pairs = 0;
  for (const PointSet& set : sets) {
    const SiteTree tree(metric, coordinates_of(set));
    std::vector<std::vector<double>> parts((count + kChunk - 1) / kChunk,
                                           std::vector<double>(result.value.size(), 0.0));
    const double bin = result.bin_width * set.mean_spacing();
    arena.for_each(parts.size(), 1, [&](std::size_t chunk) {
      const std::size_t begin = chunk * kChunk;
      count_pairs(set, metric, tree, bin, bin * bins,
                  point_range(begin, std::min(count, begin + kChunk)), parts[chunk]);
    });
    for (const auto& part : parts) {
      for (std::size_t k = 0; k < part.size(); ++k) result.value[k] += part[k];
    }
    pairs += set.count() - 1.0;
  }
  double inner = 0;
  for (double& value : result.value) {
    const double outer = inner + result.bin_width;
    value /=
        pairs * (ball_volume(first.dimension(), outer) - ball_volume(first.dimension(), inner));
    inner = outer;
  }
  return result;
}

}  // namespace ccvt
