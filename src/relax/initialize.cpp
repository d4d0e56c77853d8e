#include "relax/initialize.h"

#include <algorithm>

#include "random.h"
#include "relax/balance.h"
#include "relax/nearest_sites.h"
#include "spatial/site_tree.h"

namespace ccvt {
namespace {

constexpr std::uint64_t kOrderStream = 3;
/// Points that are on their way from memory while others join.
constexpr std::size_t kAhead = 24;
constexpr std::size_t kBetweenChecks = 1 << 12;

std::vector<Index> shuffled(std::span<const Index> points, std::uint64_t seed, const Arena& arena) {
  std::vector<Index> order(points.begin(), points.end());
  Random random(seed, kOrderStream);
  random.shuffle(std::span(order), [&](std::size_t k) {
    if (k % kBetweenChecks == 0) arena.check();
  });
  return order;
}

/// Each site with its nearest ones, each pair once.
std::vector<Pair> nearest_neighbours(const Metric& metric, const SiteState& sites,
                                     const Arena& arena) {
  const int wanted = 1 + std::min(24, 3 + 2 * metric.dimension());
  const SiteTree tree(metric, sites.position);
  const auto count = static_cast<std::size_t>(sites.count());
  std::vector<std::vector<Index>> found(count);
  arena.for_each(count, 64, [&](std::size_t s) {
    tree.nearest(sites.at(static_cast<Index>(s)), wanted, found[s]);
  });
  std::vector<Pair> pairs;
  for (std::size_t s = 0; s < count; ++s) {
    const auto site = static_cast<Index>(s);
    for (const Index other : found[s]) {
      if (other != site) pairs.emplace_back(std::min(site, other), std::max(site, other));
    }
  }
  sort_pairs(pairs, sites.count());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  return pairs;
}

}  // namespace

template <class Scalar>
void join_coherent(const Metric& metric, const SiteState& sites, std::span<const Index> joining,
                   std::uint64_t seed, Filling<Scalar>& filling, const Arena& arena) {
  SiteTree available(metric, sites.position);
  for (Index s = 0; s < sites.count(); ++s) {
    if (filling.surplus(s) == 0) available.remove(s);
  }
  std::vector<double> query(static_cast<std::size_t>(metric.dimension()));
  for (const Index point : shuffled(joining, seed, arena)) {
    arena.check();
    std::copy_n(filling.points[point], query.size(), query.begin());
    const Index site = available.nearest(query.data());
    filling.add(site, point);
    if (filling.surplus(site) == 0) available.remove(site);
  }
}

template <class Scalar>
void join_balanced(const Metric& metric, const SiteState& sites, const Box& box,
                   std::span<const Index> joining, std::span<const Pair> near, const Arena& arena,
                   Filling<Scalar>& filling) {
  {
    const NearestSites<Scalar> nearest(metric, sites, box);
    typename NearestSites<Scalar>::Found found;
    // Bounds the memory, yet leaves each bin many points.
    const std::size_t chunk = std::max(std::size_t{1} << 18, 64 * sites.radius.size());
    const auto add = [&](std::size_t begin, std::size_t end) {
      for (std::size_t k = begin; k < end; ++k) {
        if (k + kAhead < end) __builtin_prefetch(filling.points[found.point[k + kAhead]]);
        filling.add(found.site[k], found.point[k]);
      }
    };
    for (std::size_t begin = 0; begin < joining.size(); begin += chunk) {
      nearest(filling.points, joining.subspan(begin, std::min(chunk, joining.size() - begin)),
              arena, found, add);
    }
  }
  if (near.empty()) {
    balance(metric, sites, nearest_neighbours(metric, sites, arena), arena, filling);
  } else {
    balance(metric, sites, near, arena, filling);
  }
}

template <class Scalar>
void join_random(std::span<const Index> joining, std::uint64_t seed, Filling<Scalar>& filling,
                 const Arena& arena) {
  const std::vector<Index> order = shuffled(joining, seed, arena);
  auto next = order.begin();
  for (Index s = 0; s < filling.cells.site_count(); ++s) {
    arena.check();
    while (filling.surplus(s) < 0) filling.add(s, *next++);
  }
}

#define CCVT_INSTANTIATE(Scalar)                                                                   \
  template void join_coherent(const Metric&, const SiteState&, std::span<const Index>,             \
                              std::uint64_t, Filling<Scalar>&, const Arena&);                      \
  template void join_balanced(const Metric&, const SiteState&, const Box&, std::span<const Index>, \
                              std::span<const Pair>, const Arena&, Filling<Scalar>&);              \
  template void join_random(std::span<const Index>, std::uint64_t, Filling<Scalar>&, const Arena&);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
