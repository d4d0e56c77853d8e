#include "relax/initialize.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "parallel/loops.h"
#include "parallel/together.h"
#include "random.h"
#include "relax/add_near.h"
#include "relax/balance.h"
#include "relax/home.h"
#include "schedule/own_pairs.h"
#include "spatial/site_tree.h"
#include "streams.h"

namespace ccvt {
namespace {

constexpr std::size_t kBetweenChecks = 1 << 12;
constexpr std::size_t kSitesPerGrain = 64;
/// One point is looked up ahead for so many sites with room, or points that have none yet: few find
/// that it is gone when they come. When an eighth of them does, it is time to look anew.
constexpr std::size_t kSitesAPointAhead = 16;
constexpr std::size_t kPointsAPointAhead = 64;
constexpr std::size_t kMostAhead = 1 << 14;
constexpr std::size_t kQueriesPerGrain = 8;
/// Points found at once, per site: bounds the memory, yet leaves each bin many points.
constexpr std::size_t kPointsPerSite = 32;
constexpr std::size_t kLeastPoints = 1 << 18;

std::vector<PointNumber> shuffled(std::span<const PointNumber> points, std::uint64_t seed,
                                  const Arena& arena) {
  std::vector<PointNumber> order(points.begin(), points.end());
  Random random(seed, streams::joining_order);
  random.shuffle(std::span(order), [&](std::size_t k) {
    if (k % kBetweenChecks == 0) arena.check();
  });
  return order;
}

/// Each site with its nearest ones, each pair once; of several ranks, each has those of its sites.
Buffer<Pair> nearest_neighbours(const Metric& metric, const SiteState& sites, const Tiling& tiling,
                                const Arena& arena) {
  const int wanted = 1 + std::min(24, 3 + 2 * metric.dimension());
  const SiteTree tree(metric, sites.position);
  PerWorker<std::vector<Index>> scratch(arena);
  Buffer<Pair> found =
      collect_of_own_sites<Pair>(arena, tiling, kSitesPerGrain,
                                 [&](NumberRange<SiteNumber> own, std::vector<Pair>& pairs, int w) {
                                   for (const SiteNumber site : own) {
                                     scratch[w].clear();
                                     tree.nearest(sites.at(site), wanted, scratch[w]);
                                     for (const Index near : scratch[w]) {
                                       const SiteNumber other(near);
                                       if (other != site)
                                         pairs.push_back(Pair::ascending(site, other));
                                     }
                                   }
                                 });
  return sorted_pairs(arena, with_pairs_of_others(tiling, std::move(found)), sites.count());
}

/// Adds points to the sites that they are nearest to, part by part.
template <std::size_t Dimension, class Scalar>
void add_to_nearest(const NearestSites<Scalar>& nearest, const JoiningPoints& joining,
                    const Arena& arena, Filling<Scalar>& filling) {
  const std::size_t part = std::max(kLeastPoints, kPointsPerSite * filling.cells.site_count());
  typename NearestSites<Scalar>::template Found<Dimension> found;
  joining.for_parts(part, arena, [&](std::span<const PointNumber> which) {
    nearest.template find<Dimension>(filling.points.view(), which, arena, found);
    const auto charge = arena.phase(Phase::join);
    add_near(arena, found.points, found.spare, filling);
  });
}

/// The same by several ranks, each part by part of its own points. In the end points are in the
/// order in which one process would have added them: part by part of all, in these as find() has
/// them.
template <std::size_t Dimension, class Scalar>
void add_to_nearest_on_ranks(const NearestSites<Scalar>& nearest, const JoiningPoints& joining,
                             const Arena& arena, Filling<Scalar>& filling) {
  const Tiling& tiling = filling.tiles;
  const std::size_t part = std::max(kLeastPoints, kPointsPerSite * filling.cells.site_count());
  const std::vector<Index> before = filling.filled;
  Arrivals arrivals(*tiling.ranks(), joining.own_begin(), joining.end(), before.size());
  typename NearestSites<Scalar>::template Found<Dimension> found;
  const auto add = [&](std::span<const PointNumber> which) {
    nearest.template find<Dimension>(filling.points.view(), which, arena, found);
    const auto charge = arena.phase(Phase::join);
    if constexpr (Dimension > 0) {
      add_at_home<Dimension>(found, arena, filling, arrivals);
    } else {
      add_at_home<Scalar>(found.points.span(), arena, filling);
    }
  };
  joining.for_own_parts(
      std::max(kLeastPoints, part / static_cast<std::size_t>(tiling.ranks()->count())), part, arena,
      [&](std::span<const PointNumber> which) {
        any(tiling.ranks(), true);
        add(which);
      });
  while (any(tiling.ranks(), false)) add({});  // others have more

  const auto charge = arena.phase(Phase::join);
  const std::vector<PointOfAll> begins = joining.parts(part);
  for_each_site(arena, tiling, [&](SiteNumber s) {
    if (Dimension > 0 && arrivals.in_order(s)) return;
    filling.sort_added(s, before[s], [&](PointOfAll point, const Scalar* x) {
      const auto of_part = std::upper_bound(begins.begin(), begins.end(), point) - begins.begin();
      const std::size_t cell = Dimension > 0 ? nearest.cell_of(x) : 0;
      return std::tuple(of_part, cell, point);
    });
  });
}

}  // namespace

template <class Scalar>
void join_coherent(const Metric& metric, const SiteState& sites,
                   std::span<const PointNumber> joining, std::uint64_t seed,
                   Filling<Scalar>& filling, const Arena& arena) {
  SiteTree available(metric, sites.position);
  for (const SiteNumber s : sites.all()) {
    if (filling.surplus(s) == 0) available.remove(s.index());
  }
  const auto nearest = [&](PointNumber point) {
    std::vector<double> query(sites.dimension);
    std::copy_n(filling.points[point], query.size(), query.begin());
    return SiteNumber(available.nearest(query.data()));
  };
  const std::vector<PointNumber> order = shuffled(joining, seed, arena);
  std::vector<SiteNumber> expected;
  for (std::size_t next = 0; next < order.size();) {
    // Where each of the next points goes unless those before it take the last room there.
    const std::size_t left = order.size() - next;
    const auto sites_left = static_cast<std::size_t>(available.available());
    const std::size_t ahead = std::max(sites_left / kSitesAPointAhead, left / kPointsAPointAhead);
    expected.resize(std::min(left, std::clamp<std::size_t>(ahead, 1, kMostAhead)));
    const std::size_t begin = next;
    arena.for_each(expected.size(), kQueriesPerGrain,
                   [&](std::size_t k) { expected[k] = nearest(order[begin + k]); });
    for (std::size_t k = 0, missed = 0; k < expected.size() && 8 * missed <= k + 8; ++k, ++next) {
      SiteNumber site = expected[k];
      if (filling.surplus(site) >= 0) {
        arena.check();
        site = nearest(order[next]);
        ++missed;
      }
      filling.add(site, order[next]);
      if (filling.surplus(site) == 0) available.remove(site.index());
    }
  }
}

template <class Scalar>
void join_balanced(const Metric& metric, const SiteState& sites, const Box& box,
                   const JoiningPoints& joining, std::span<const Pair> near, const Arena& arena,
                   Filling<Scalar>& filling) {
  {
    const auto charge = arena.phase(Phase::nearest);
    const NearestSites<Scalar> nearest(metric, sites, box, arena);
    with_dimension(nearest.dimension_of_copies(), [&]<std::size_t Dimension>() {
      if (filling.tiles.ranks() != nullptr) {
        add_to_nearest_on_ranks<Dimension>(nearest, joining, arena, filling);
      } else {
        add_to_nearest<Dimension>(nearest, joining, arena, filling);
      }
    });
  }
  const Tiling& tiling = filling.tiles;
  if (!any(tiling.ranks(), !near.empty())) {
    const auto charge = arena.phase(Phase::graph);
    const Buffer<Pair> pairs = nearest_neighbours(metric, sites, tiling, arena);
    balance(metric, sites, pairs, arena, filling);
  } else {
    balance(metric, sites, near, arena, filling);
  }
}

template <class Scalar>
void join_random(std::span<const PointNumber> joining, std::uint64_t seed, Filling<Scalar>& filling,
                 const Arena& arena) {
  const std::vector<PointNumber> order = shuffled(joining, seed, arena);
  auto next = order.begin();
  for (const SiteNumber s : filling.cells.sites()) {
    arena.check();
    while (filling.surplus(s) < 0) filling.add(s, *next++);
  }
}

#define CCVT_INSTANTIATE(Scalar)                                                                 \
  template void join_coherent(const Metric&, const SiteState&, std::span<const PointNumber>,     \
                              std::uint64_t, Filling<Scalar>&, const Arena&);                    \
  template void join_balanced(const Metric&, const SiteState&, const Box&, const JoiningPoints&, \
                              std::span<const Pair>, const Arena&, Filling<Scalar>&);            \
  template void join_random(std::span<const PointNumber>, std::uint64_t, Filling<Scalar>&,       \
                            const Arena&);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
