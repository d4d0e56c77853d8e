#include "exact/neighbourhoods.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <numeric>
#include <utility>

#include "exact/grouping.h"
#include "exact/packs.h"
#include "geometry/squares.h"
#include "parallel/loops.h"

namespace ccvt {
namespace {

/// So many positions or more are first divided among leaders, so many times the root of them, but
/// not too many. Leaders are placed by so many positions each.
constexpr std::size_t kManyPositions = 2048;
constexpr double kLeadersPerRoot = 8;
constexpr std::size_t kMostLeaders = 1024;
constexpr std::size_t kPlacedBy = 8;
constexpr std::size_t kPositionsPerGrain = 64;
/// Where groups are too large, a part has no less than this share of one.
constexpr std::size_t kLeastShare = 8;
/// Groups that are not too large, but no smaller than this share, are divided as well where that
/// brings the mean of their squared radius down to so much: between clouds.
constexpr std::size_t kSmall = 8;
constexpr double kFall = 0.7;
/// Means on a line, of two parts, are found in so many steps.
constexpr int kSteps = 4;

struct Place {
  double along;
  SiteNumber site;
  auto operator<=>(const Place&) const = default;
};

/// A run of sites that is to be divided.
struct Run {
  std::size_t begin, end;
  [[nodiscard]] std::size_t size() const { return end - begin; }
};

/// Where the middle between the means of two parts of a line is, with the parts as that says.
double middle_of(std::span<const Place> places) {
  const auto [low, high] = std::minmax_element(places.begin(), places.end());
  double middle = low->along + (high->along - low->along) / 2;
  for (int step = 0; step < kSteps; ++step) {
    std::array<double, 2> sum{};
    std::array<double, 2> count{};
    for (const Place& place : places) {
      const std::size_t side = place.along < middle ? 0 : 1;
      sum[side] += place.along;
      ++count[side];
    }
    if (count[0] == 0 || count[1] == 0) break;
    middle = (sum[0] / count[0] + sum[1] / count[1]) / 2;
  }
  return middle;
}

/// Divides runs of one set of positions.
class Divider {
 public:
  Divider(std::span<const double> positions, std::size_t dimension)
      : positions_(positions), dimension_(dimension) {}

  /// Brings the sites of one part before those of the other, with no fewer than `least` in each;
  /// returns how many are in the first.
  std::size_t divide(std::span<SiteNumber> sites, std::size_t least) const {
    const double* const a = farthest_from(at(sites.front()), sites);
    const double* const b = farthest_from(a, sites);
    std::vector<Place> places(sites.size());
    for (std::size_t k = 0; k < sites.size(); ++k) {
      const double* const x = at(sites[k]);
      double along = 0;
      for (std::size_t d = 0; d < dimension_; ++d) along += (x[d] - a[d]) * (b[d] - a[d]);
      places[k] = {along, sites[k]};
    }
    const double middle = middle_of(places);
    const auto before = static_cast<std::size_t>(std::count_if(
        places.begin(), places.end(), [&](const Place& place) { return place.along < middle; }));
    const std::size_t first = std::clamp(before, least, sites.size() - least);
    std::nth_element(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(first),
                     places.end());
    std::transform(places.begin(), places.end(), sites.begin(),
                   [](const Place& place) { return place.site; });
    return first;
  }

  /// Sites times the squared distance of the farthest to their mean.
  [[nodiscard]] double spread(std::span<const SiteNumber> sites) const {
    std::vector<double> mean(dimension_, 0.0);
    const auto size = static_cast<double>(sites.size());
    for (const SiteNumber s : sites) {
      for (std::size_t d = 0; d < dimension_; ++d) mean[d] += at(s)[d] / size;
    }
    double most = 0;
    for (const SiteNumber s : sites) {
      most = std::max(most, squared_difference(at(s), mean.data(), static_cast<int>(dimension_)));
    }
    return size * most;
  }

 private:
  [[nodiscard]] const double* at(SiteNumber site) const {
    return positions_.data() + site * dimension_;
  }
  [[nodiscard]] const double* farthest_from(const double* x,
                                            std::span<const SiteNumber> sites) const {
    const double* farthest = x;
    double most = 0;
    for (const SiteNumber s : sites) {
      const double squared = squared_difference(at(s), x, static_cast<int>(dimension_));
      if (squared > most) {
        most = squared;
        farthest = at(s);
      }
    }
    return farthest;
  }

  std::span<const double> positions_;
  std::size_t dimension_;
};

/// `count` of the positions, taken evenly from among them.
std::vector<double> some_of(std::span<const double> positions, std::size_t dimension,
                            std::size_t count) {
  const std::size_t n = positions.size() / dimension;
  std::vector<double> some;
  some.reserve(count * dimension);
  for (std::size_t k = 0; k < count; ++k) {
    const double* const x = positions.data() + (2 * k + 1) * n / (2 * count) * dimension;
    some.insert(some.end(), x, x + dimension);
  }
  return some;
}

/// Positions grouped by the nearest leader. O(positions leaders D).
Grouping group_by_leader(std::span<const double> positions, std::size_t dimension,
                         std::span<const double> leaders, const Arena& arena) {
  const std::vector<double> packs = packs_of(leaders, dimension);
  const std::size_t count = leaders.size() / dimension;
  const auto filled = static_cast<std::ptrdiff_t>(packs.size() / dimension - count);
  std::vector<Index> nearest(positions.size() / dimension);
  std::vector<SiteNumber> all(nearest.size());
  std::iota(all.begin(), all.end(), SiteNumber(0));
  const auto at = [&](SiteNumber k) { return positions.data() + k * dimension; };
  PerWorker<PackedDistances> distances(arena);
  arena.for_ranges(
      nearest.size(), kPositionsPerGrain, [&](std::size_t begin, std::size_t end, int worker) {
        arena.check();
        const auto some = std::span(all).subspan(begin, end - begin);
        distances[worker].for_each(some, at, packs, static_cast<int>(dimension), nullptr,
                                   [&](SiteNumber k, std::span<const double> squared) {
                                     const auto least =
                                         std::min_element(squared.begin(), squared.end() - filled);
                                     nearest[k] = static_cast<Index>(least - squared.begin());
                                   });
      });
  return {nearest, count};
}

/// Puts the positions in order by the leader that is nearest, and returns where a leader's begin:
/// lines across all would cut many of the clouds that there may be. Leaders are the means of some
/// positions that one of them is nearest to. O(n^1.5 D).
std::vector<std::size_t> divide_among_leaders(std::span<const double> positions,
                                              std::size_t dimension, const Arena& arena,
                                              std::vector<SiteNumber>& order) {
  const std::size_t n = order.size();
  const auto wanted = static_cast<std::size_t>(kLeadersPerRoot * std::sqrt(static_cast<double>(n)));
  const std::size_t count = std::min(kMostLeaders, wanted);
  std::vector<double> leaders = some_of(positions, dimension, count);
  const std::vector<double> some = some_of(positions, dimension, std::min(n, kPlacedBy * count));
  const Grouping placing = group_by_leader(some, dimension, leaders, arena);
  for (const SiteNumber leader : sites_below(count)) {
    const auto members = placing.of(leader);
    if (members.empty()) continue;
    double* const to = leaders.data() + leader * dimension;
    std::fill(to, to + dimension, 0.0);
    for (const PointNumber p : members) {
      const double* const x = some.data() + p * dimension;
      for (std::size_t d = 0; d < dimension; ++d) to[d] += x[d];
    }
    for (std::size_t d = 0; d < dimension; ++d) to[d] /= static_cast<double>(members.size());
  }
  const Grouping parts = group_by_leader(positions, dimension, leaders, arena);
  std::vector<std::size_t> begin;
  order.clear();
  for (const SiteNumber leader : sites_below(count)) {
    if (parts.of(leader).empty()) continue;
    begin.push_back(order.size());
    for (const PointNumber p : parts.of(leader)) order.emplace_back(p.index());
  }
  return begin;
}

}  // namespace

Neighbourhoods::Neighbourhoods(std::span<const double> positions, std::size_t dimension,
                               std::size_t most, const Arena& arena)
    : order(positions.size() / dimension) {
  std::iota(order.begin(), order.end(), SiteNumber(0));
  const Divider divider(positions, dimension);
  // How many of a run come first, or 0 where it is a group.
  const auto divide = [&](Run run) -> std::size_t {
    const auto sites = std::span(order).subspan(run.begin, run.size());
    if (sites.size() > most) {
      return divider.divide(sites, std::max<std::size_t>(1, sites.size() / kLeastShare));
    }
    if (sites.size() < 2 || sites.size() < most / kSmall) return 0;
    const std::size_t first = divider.divide(sites, 1);
    const double apart = divider.spread(sites.first(first)) + divider.spread(sites.subspan(first));
    return apart <= kFall * divider.spread(sites) ? first : 0;
  };
  std::vector<Run> groups;
  std::vector<Run> all = {{0, order.size()}};
  if (order.size() >= kManyPositions) {
    all.clear();
    std::vector<std::size_t> parts = divide_among_leaders(positions, dimension, arena, order);
    parts.push_back(order.size());
    for (std::size_t k = 0; k + 1 < parts.size(); ++k) all.push_back({parts[k], parts[k + 1]});
  }
  for (std::vector<Run> runs = std::move(all); !runs.empty();) {
    std::vector<std::size_t> first(runs.size(), 0);
    arena.for_each(runs.size(), 1, [&](std::size_t k) { first[k] = divide(runs[k]); });
    std::vector<Run> parts;
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const auto [from, to] = runs[k];
      if (first[k] == 0) {
        groups.push_back(runs[k]);
      } else {
        parts.push_back({from, from + first[k]});
        parts.push_back({from + first[k], to});
      }
    }
    runs = std::move(parts);
  }
  std::sort(groups.begin(), groups.end(),
            [](const Run& a, const Run& b) { return a.begin < b.begin; });
  for (const Run& group : groups) begin.push_back(group.begin);
  begin.push_back(order.size());
}

std::vector<Index> Neighbourhoods::groups() const {
  std::vector<Index> group(order.size());
  for (std::size_t g = 0; g < count(); ++g) {
    for (const SiteNumber s : of(g)) group[s] = static_cast<Index>(g);
  }
  return group;
}

std::vector<double> Neighbourhoods::means(std::span<const double> positions,
                                          std::size_t dimension) const {
  std::vector<double> mean(count() * dimension, 0.0);
  for (std::size_t g = 0; g < count(); ++g) {
    double* const to = mean.data() + g * dimension;
    const auto size = static_cast<double>(of(g).size());
    for (const SiteNumber s : of(g)) {
      const double* const x = positions.data() + s * dimension;
      for (std::size_t d = 0; d < dimension; ++d) to[d] += x[d] / size;
    }
  }
  return mean;
}

}  // namespace ccvt
