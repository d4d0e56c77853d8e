#include "relax/site_graph.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "relax/disjoint_sets.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 256;

/// The sites paired with each, ascending.
Groups<SiteNumber> neighbours_in(std::size_t sites, std::span<const Pair> pairs,
                                 const Arena& arena) {
  auto ends = group_by_key<Pair>(
      arena, 2 * pairs.size(), sites,
      [&](std::size_t k) {
        const auto& [a, b] = pairs[k / 2];
        return k % 2 == 0 ? Pair(a, b) : Pair(b, a);
      },
      [](const Pair& pair) { return pair.first; });
  Groups<SiteNumber> neighbours{Buffer<SiteNumber>(ends.items.size()), std::move(ends.first)};
  for_each_site(arena, sites, kSitesPerGrain, [&](SiteNumber s) {
    const auto to = neighbours[s];
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = ends.items[neighbours.first[s] + k].second;
    if (!std::is_sorted(to.begin(), to.end())) std::sort(to.begin(), to.end());
  });
  return neighbours;
}

}  // namespace

/// With a as the origin, k is in the diametral ball of a and b when |k|^2 < k . b.
Buffer<Pair> gabriel_pairs(const Metric& metric, const SiteState& sites,
                           std::span<const Pair> pairs, const Tiling& tiling, const Arena& arena) {
  const Groups<SiteNumber> neighbours = neighbours_in(sites.count(), pairs, arena);
  const int dimension = metric.dimension();
  struct Neighbour {
    double squared;
    SiteNumber site;
    std::size_t offset;
  };
  struct Scratch {
    std::vector<Neighbour> nearest_first;
    std::vector<double> offsets;
  };
  PerWorker<Scratch> scratch(arena);
  const auto keep = [&](SiteNumber a, std::vector<Pair>& kept, int worker) {
    Scratch& own = scratch[worker];
    own.nearest_first.clear();
    own.offsets.clear();
    for (const SiteNumber b : neighbours[a]) {
      own.nearest_first.push_back({0, b, own.offsets.size()});
      for (int d = 0; d < dimension; ++d) {
        own.offsets.push_back(metric.wrap(sites.at(b)[d] - sites.at(a)[d], d));
        own.nearest_first.back().squared += own.offsets.back() * own.offsets.back();
      }
    }
    std::sort(own.nearest_first.begin(), own.nearest_first.end(), [](const auto& x, const auto& y) {
      return x.squared != y.squared ? x.squared < y.squared : x.site < y.site;
    });
    for (auto next = own.nearest_first.begin(); next != own.nearest_first.end(); ++next) {
      if (next->site < a) continue;
      const auto between = [&](const Neighbour& other) {
        double along = 0;
        for (std::size_t d = 0; d < sites.dimension; ++d) {
          along += own.offsets[other.offset + d] * own.offsets[next->offset + d];
        }
        return other.squared < along;
      };
      if (std::none_of(own.nearest_first.begin(), next, between)) kept.emplace_back(a, next->site);
    }
  };
  return collect_by_site_together<Pair>(arena, tiling, kSitesPerGrain, keep);
}

SiteGraph::SiteGraph(std::size_t sites, std::span<const Pair> edges, const Arena& arena)
    : neighbours_(neighbours_in(sites, edges, arena)), tree_(neighbours_, arena) {
  if (tree_.size() == neighbours_.count()) return;
  std::vector<Pair> all(edges.begin(), edges.end());
  DisjointSets<SiteNumber> sets(sites);
  for (const auto& [a, b] : edges) sets.join(a, b);
  for (const SiteNumber s : sites_below(sites - 1)) {
    if (sets.join(s, s.next())) all.emplace_back(s, s.next());
  }
  neighbours_ = neighbours_in(sites, all, arena);
  tree_ = SpanningTree(neighbours_, arena);
}

}  // namespace ccvt
