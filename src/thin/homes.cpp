#include "thin/homes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "ccvt/metrics.h"
#include "median.h"
#include "metrics/sets.h"
#include "relax/meeting_pairs.h"
#include "relax/update.h"
#include "schedule/tiling.h"
#include "spatial/site_tree.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = std::size_t{1} << 14;
constexpr std::size_t kSitesPerGrain = 256;
/// Neighbours whose spacing counts for a home.
constexpr std::size_t kNeighbours = 12;
constexpr std::size_t kFewNeighbours = 4;
/// A home with more pairs than this, in the mean, has its nearest ones only.
constexpr std::size_t kMostPairs = 128;
constexpr int kNearest = 48;
/// Rounds of smoothing, and more the fewer points a home has.
constexpr int kLeastSmoothing = 2;
constexpr double kSmoothing = 64;
/// Of how far apart sites would be if they were packed as densely as can be, two chosen points
/// repel each other up to this share, less with few points a home: with a shorter reach their mean
/// distance falls, with a longer one their smallest, and searches take longer.
constexpr double kReach = 1;
constexpr double kReachOfFew = 0.2;

/// The nearest `count` homes of each, itself first unless others are in the same place.
std::vector<Index> nearest_homes(const Metric& metric, const SiteState& centres, int count,
                                 const Arena& arena) {
  const SiteTree tree(metric, centres.position);
  const auto each = static_cast<std::size_t>(count);
  std::vector<Index> nearest(centres.count() * each);
  arena.for_ranges(centres.count(), kSitesPerGrain, [&](std::size_t begin, std::size_t end, int) {
    std::vector<Index> found;
    for (const SiteNumber h : sites_between(begin, end)) {
      found.clear();
      tree.nearest(centres.at(h), count, found);
      std::copy(found.begin(), found.end(), &nearest[h * each]);
    }
  });
  return nearest;
}

/// What values are around each home: medians of neighbours, as outliers say nothing, and then means
/// of these, the more rounds the fewer points a home has, as their density is chance.
void smooth(std::vector<double>& values, double points_each, std::span<const Index> nearest,
            std::size_t each, const Arena& arena) {
  const int rounds = kLeastSmoothing + static_cast<int>(kSmoothing / points_each);
  for (int round = 0; round < rounds; ++round) {
    const std::vector<double> before = values;
    for_each_site(arena, values.size(), kSitesPerGrain, [&](SiteNumber h) {
      std::array<double, kNeighbours + 1> around{};
      double sum = 0;
      for (std::size_t k = 0; k < each; ++k) {
        around.data()[k] = before[SiteNumber(nearest[h * each + k])];
        sum += around.data()[k];
      }
      values[h] =
          round == 0 ? median(std::span(around).first(each)) : sum / static_cast<double>(each);
    });
  }
}

/// In so many dimensions as the centres spread over locally, on a surface two: balls around a
/// centre grow with this power of their radius. Between 1 and that of space.
int intrinsic_dimension(const Metric& metric, std::span<const double> inner,
                        std::span<const double> outer) {
  double sum = 0;
  double count = 0;
  for (std::size_t h = 0; h < inner.size(); ++h) {
    if (!(inner[h] > 0)) continue;
    sum += std::log(outer[h] / inner[h]);
    count += 1;
  }
  const double growth = std::log((kNeighbours + 0.5) / (kFewNeighbours + 0.5));
  const double dimension = sum > 0 ? std::round(count * growth / sum) : 1;
  return static_cast<int>(std::clamp<double>(dimension, 1, metric.dimension()));
}

/// The reach of each home, for so many points a home, from how far its neighbours are.
std::vector<double> reaches(const Metric& metric, const SiteState& centres, double points_each,
                            const Arena& arena) {
  std::vector<double> outer(centres.count(), 0.0);
  std::vector<double> inner = outer;
  const auto each = std::min<std::size_t>(kNeighbours + 1, centres.count());
  if (each < 2) return outer;
  const std::vector<Index> nearest = nearest_homes(metric, centres, static_cast<int>(each), arena);
  for_each_site(arena, centres.count(), kSitesPerGrain, [&](SiteNumber h) {
    const auto distance = [&](std::size_t k) {
      const SiteNumber other(nearest[h * each + std::min(k, each - 1)]);
      return std::sqrt(metric.squared_distance(centres.at(h), centres.at(other)));
    };
    inner[h] = distance(kFewNeighbours);
    outer[h] = distance(kNeighbours);
  });
  const int dimension = intrinsic_dimension(metric, inner, outer);
  smooth(outer, points_each, nearest, each, arena);
  // A ball of this radius around a centre holds as many others, and half of the last one.
  const double spacing =
      packing_distance(dimension) *
      std::pow(ball_volume(dimension, 1) / (static_cast<double>(each) - 0.5), 1.0 / dimension);
  const double factor = spacing * (kReach - kReachOfFew / std::sqrt(points_each));
  for (double& reach : outer) reach *= factor;
  return outer;
}

/// Both ways, and each home with itself.
Groups<SiteNumber> near_of_pairs(std::span<const Pair> pairs, std::size_t homes,
                                 const Arena& arena) {
  const std::size_t count = 2 * pairs.size() + homes;
  Groups<Pair> both = pairs_by_first(
      arena,
      [&] {
        Buffer<Pair> directed(count);
        for (std::size_t k = 0; k < pairs.size(); ++k) {
          directed[2 * k] = pairs[k];
          directed[2 * k + 1] = Pair(pairs[k].second, pairs[k].first);
        }
        for (const SiteNumber h : sites_below(homes)) directed[2 * pairs.size() + h] = Pair(h, h);
        return directed;
      }(),
      homes);
  Groups<SiteNumber> near{Buffer<SiteNumber>(count), std::move(both.first)};
  for (std::size_t k = 0; k < count; ++k) near.items[k] = both.items[k].second;
  return near;
}

template <class Scalar>
Groups<SiteNumber> find_near(const Metric& metric, const Homes<Scalar>& homes, const Arena& arena) {
  SiteState grown = homes.centres;
  for (const SiteNumber h : grown.all()) grown.radius[h] += homes.reach[h] / 2;
  MeetingPairs meeting;
  const std::size_t limit = kMostPairs * homes.count();
  const Tiling alone(homes.count(), 1);
  if (meeting.refresh(metric, grown, alone, arena, limit) != MeetingPairs::Refreshed::too_many) {
    return near_of_pairs(meeting.pairs(), homes.count(), arena);
  }
  const auto each = std::min<std::size_t>(kNearest, homes.count());
  const std::vector<Index> nearest =
      nearest_homes(metric, homes.centres, static_cast<int>(each), arena);
  std::vector<Pair> pairs;
  for (const SiteNumber h : grown.all()) {
    for (std::size_t k = 0; k < each; ++k) {
      const SiteNumber other(nearest[h * each + k]);
      if (other != h) pairs.push_back(Pair::ascending(h, other));
    }
  }
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return near_of_pairs(pairs, homes.count(), arena);
}

}  // namespace

template <class Scalar>
Homes<Scalar> make_homes(const Metric& metric, PointsView<Scalar> points,
                         std::span<const Index> owners, PointsView<Scalar> centres,
                         const Arena& arena) {
  const auto count = static_cast<std::size_t>(centres.count);
  const std::size_t dimension = metric.coordinate_count();
  Homes<Scalar> homes;
  homes.points = group_by_key<PointNumber>(
      arena, owners.size(), count, [](std::size_t p) { return PointNumber(p); },
      [&](PointNumber p) { return std::size_t{SiteNumber(owners[p])}; });
  homes.coordinates.reset(owners.size() * dimension);
  homes.home_of.resize(owners.size());
  arena.for_each(owners.size(), kPointsPerGrain, [&](std::size_t k) {
    const PointNumber p = homes.points.items[k];
    std::copy_n(points[p.index()], dimension, homes.coordinates.data() + k * dimension);
    homes.home_of[k] = SiteNumber(owners[p]);
  });
  homes.centres = SiteState(dimension, count);
  for_each_site(arena, count, kSitesPerGrain, [&](SiteNumber h) {
    double* const centre = homes.centres.at(h);
    std::copy_n(centres[h.index()], dimension, centre);
    double squared = 0;
    for (std::size_t k = homes.points.first[h]; k < homes.points.first[h + 1]; ++k) {
      squared = std::max(squared,
                         metric.squared_distance(homes.coordinates.data() + k * dimension, centre));
    }
    homes.centres.radius[h] = upper_radius(squared, metric.dimension());
  });
  homes.reach = reaches(metric, homes.centres,
                        static_cast<double>(points.count) / static_cast<double>(count), arena);
  homes.near = find_near(metric, homes, arena);
  return homes;
}

template Homes<float> make_homes(const Metric&, PointsView<float>, std::span<const Index>,
                                 PointsView<float>, const Arena&);
template Homes<double> make_homes(const Metric&, PointsView<double>, std::span<const Index>,
                                  PointsView<double>, const Arena&);

}  // namespace ccvt
