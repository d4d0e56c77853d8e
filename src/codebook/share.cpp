#include "codebook/share.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "cell_sizes.h"
#include "codebook/linkage.h"
#include "codebook/seeding.h"
#include "exact/centroids.h"
#include "geometry/chosen_points.h"
#include "numbers.h"
#include "parallel/together.h"
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
std::vector<Index> draw_evenly(const Vectors<Scalar>& points, const std::vector<double>& sites,
                               Index count, std::uint64_t seed, const Arena& arena) {
  const auto& [ranks, first] = points.part();
  const Metric metric(points.dimension(), Domain());
  const std::size_t n = sites.size() / static_cast<std::size_t>(points.dimension());
  const std::vector<Index> owners =
      nearest_owners(metric, points.here(), sites, arena, points.part());
  const Grouping regions(owners, n, arena);
  const std::vector<Index> sizes = joined(ranks, cell_sizes(owners, n));  // of each rank's regions
  Random random(seed, streams::codebook_levels);
  std::vector<Index> chosen;
  std::int64_t before = 0;
  std::int64_t taken = 0;
  const auto place = [&] { return (2 * taken + 1) * points.count() / (2 * std::int64_t{count}); };
  for (const SiteNumber s : linkage_order(sites, points.dimension(), arena)) {
    Index lower = 0;  // members on lower ranks
    Index size = 0;
    for (std::size_t rank = 0; rank * n < sizes.size(); ++rank) {
      const Index here = sizes[rank * n + s];
      if (ranks != nullptr && std::cmp_less(rank, ranks->rank())) lower += here;
      size += here;
    }
    std::vector<Index> order(static_cast<std::size_t>(size));
    std::iota(order.begin(), order.end(), 0);
    random.shuffle(std::span(order));  // the points' own order may be periodic
    for (; taken < count && place() < before + size; ++taken) {
      const Index member = order[static_cast<std::size_t>(place() - before)] - lower;
      const auto own = regions.of(s);
      if (member < 0 || std::cmp_greater_equal(member, own.size())) continue;
      const Index p = own[static_cast<std::size_t>(member)].index();
      chosen.push_back(static_cast<Index>(first) + p);
    }
    before += size;
  }
  return chosen;
}

template <class Scalar>
std::vector<double> share_sites(PointsView<Scalar> points, std::span<const Index> owners,
                                const std::vector<double>& sites, std::span<const Index> capacities,
                                std::uint64_t seed, const Arena& arena) {
  const auto width = static_cast<std::size_t>(points.dimension);
  const Grouping cells(owners, capacities.size());
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

template std::vector<Index> draw_evenly(const Vectors<float>&, const std::vector<double>&, Index,
                                        std::uint64_t, const Arena&);
template std::vector<Index> draw_evenly(const Vectors<double>&, const std::vector<double>&, Index,
                                        std::uint64_t, const Arena&);
template std::vector<double> share_sites(PointsView<float>, std::span<const Index>,
                                         const std::vector<double>&, std::span<const Index>,
                                         std::uint64_t, const Arena&);
template std::vector<double> share_sites(PointsView<double>, std::span<const Index>,
                                         const std::vector<double>&, std::span<const Index>,
                                         std::uint64_t, const Arena&);

}  // namespace ccvt
