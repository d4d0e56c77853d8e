#include "codebook/share.h"

#include <algorithm>

#include "codebook/centroids.h"
#include "codebook/linkage.h"
#include "codebook/seeding.h"
#include "geometry/chosen_points.h"
#include "numbers.h"
#include "random.h"
#include "schedule/tiling.h"
#include "streams.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 4;
/// The first level has so many vectors a codeword, the next ones so many times as many.
constexpr std::int64_t kLevelVectors = 32;
constexpr std::int64_t kLevelFactor = 4;
constexpr std::int64_t kLeastLevel = 8192;

/// How many sites each cell shall have: of each capacity the middle falls into one.
std::vector<Index> allot(const Grouping& cells, const std::vector<SiteNumber>& order,
                         std::span<const Index> capacities) {
  std::vector<Index> allotted(order.size(), 0);
  std::size_t place = 0;
  auto until = static_cast<std::int64_t>(cells.of(order.front()).size());
  std::int64_t before = 0;
  for (const Index capacity : capacities) {
    while (2 * until <= 2 * before + capacity && place + 1 < order.size()) {
      until += static_cast<std::int64_t>(cells.of(order[++place]).size());
    }
    ++allotted[order[place]];
    before += capacity;
  }
  return allotted;
}

}  // namespace

std::vector<Index> share_capacities(std::span<const Index> capacities, Index total, Index count) {
  const auto sites = static_cast<Index>(capacities.size());
  std::vector<Index> shares(capacities.size());
  std::int64_t before = 0;
  Index given = 0;
  for (std::size_t s = 0; s < capacities.size(); ++s) {
    before += capacities[s] - 1;
    // Of what is left when each site has one.
    const auto until = static_cast<Index>(total > sites ? before * (count - sites) / (total - sites)
                                                        : std::int64_t{0});
    shares[s] = 1 + until - given;
    given = until;
  }
  return shares;
}

std::vector<Index> level_sizes(Index vectors, Index codewords) {
  std::vector<Index> sizes;
  for (std::int64_t size = std::max(kLeastLevel, kLevelVectors * codewords); size * 2 < vectors;
       size *= kLevelFactor) {
    sizes.push_back(static_cast<Index>(size));
  }
  return sizes;
}

template <class Scalar>
std::vector<Index> draw_evenly(PointsView<Scalar> points, const std::vector<double>& sites,
                               Index count, std::uint64_t seed, const Arena& arena) {
  const Metric metric(points.dimension, Domain());
  const Grouping regions(nearest_owners(metric, points, sites, arena),
                         sites.size() / static_cast<std::size_t>(points.dimension));
  Random random(seed, streams::codebook_levels);
  std::vector<PointNumber> ordered;
  ordered.reserve(regions.order.size());
  for (const SiteNumber s : linkage_order(sites, points.dimension, arena)) {
    const std::size_t begin = ordered.size();
    ordered.insert(ordered.end(), regions.of(s).begin(), regions.of(s).end());
    random.shuffle(std::span(ordered).subspan(begin));  // the points' own order may be periodic
  }
  std::vector<Index> chosen;
  chosen.reserve(static_cast<std::size_t>(count));
  for (std::int64_t k = 0; k < count; ++k) {
    const std::int64_t place = (2 * k + 1) * points.count / (2 * std::int64_t{count});
    chosen.push_back(ordered[static_cast<std::size_t>(place)].index());
  }
  return chosen;
}

template <class Scalar>
std::vector<double> share_sites(PointsView<Scalar> points, const std::vector<double>& sites,
                                std::span<const Index> capacities, std::uint64_t seed,
                                const Arena& arena) {
  const auto width = static_cast<std::size_t>(points.dimension);
  const Metric metric(points.dimension, Domain());
  const Grouping cells(nearest_owners(metric, points, sites, arena), capacities.size());
  const std::vector<SiteNumber> order = linkage_order(sites, points.dimension, arena);
  const std::vector<Index> allotted = allot(cells, order, capacities);
  std::vector<std::vector<double>> parts(order.size());
  for_each_site(arena, order.size(), kSitesPerGrain, [&](SiteNumber s) {
    const auto members = cells.of(s);
    if (allotted[s] == 0) return;
    if (allotted[s] == 1) {
      parts[s].assign(sites.data() + s * width, sites.data() + (s + 1) * width);
      return;
    }
    const Points<Scalar> own = chosen_points(points, members);
    parts[s] = seed_sites<Scalar>(view_points(own), allotted[s], 1, seed, arena);
  });
  std::vector<double> shared;
  for (const SiteNumber s : order) shared.insert(shared.end(), parts[s].begin(), parts[s].end());
  return shared;
}

template std::vector<Index> draw_evenly(PointsView<float>, const std::vector<double>&, Index,
                                        std::uint64_t, const Arena&);
template std::vector<Index> draw_evenly(PointsView<double>, const std::vector<double>&, Index,
                                        std::uint64_t, const Arena&);
template std::vector<double> share_sites(PointsView<float>, const std::vector<double>&,
                                         std::span<const Index>, std::uint64_t, const Arena&);
template std::vector<double> share_sites(PointsView<double>, const std::vector<double>&,
                                         std::span<const Index>, std::uint64_t, const Arena&);

}  // namespace ccvt
