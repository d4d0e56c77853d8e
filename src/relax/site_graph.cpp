#include "relax/site_graph.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <utility>

namespace ccvt {
namespace {

class DisjointSets {
 public:
  explicit DisjointSets(Index count) : parent_(static_cast<std::size_t>(count)) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  /// Whether a and b were apart.
  bool join(Index a, Index b) {
    a = root(a);
    b = root(b);
    if (a == b) return false;
    parent_[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    return true;
  }

 private:
  Index root(Index a) {
    auto k = static_cast<std::size_t>(a);
    while (parent_[k] != static_cast<Index>(k)) {
      parent_[k] = parent_[static_cast<std::size_t>(parent_[k])];
      k = static_cast<std::size_t>(parent_[k]);
    }
    return static_cast<Index>(k);
  }
  std::vector<Index> parent_;
};

constexpr std::size_t kSitesPerGrain = 256;

/// The sites paired with each, ascending.
Groups<Index> neighbours_in(Index sites, std::span<const Pair> pairs, const Arena& arena) {
  const auto count = static_cast<std::size_t>(sites);
  auto ends = group_by_key<Pair>(
      arena, 2 * pairs.size(), count,
      [&](std::size_t k) {
        const auto& [a, b] = pairs[k / 2];
        return k % 2 == 0 ? Pair(a, b) : Pair(b, a);
      },
      [](const Pair& pair) { return static_cast<std::size_t>(pair.first); });
  Groups<Index> neighbours{Buffer<Index>(ends.items.size()), std::move(ends.first)};
  arena.for_each(count, kSitesPerGrain, [&](std::size_t s) {
    const auto to = neighbours[s];
    for (std::size_t k = 0; k < to.size(); ++k) to[k] = ends.items[neighbours.first[s] + k].second;
    std::sort(to.begin(), to.end());
  });
  return neighbours;
}

}  // namespace

/// With a as the origin, k is in the diametral ball of a and b when |k|^2 < k . b.
Buffer<Pair> gabriel_pairs(const Metric& metric, const SiteState& sites,
                           std::span<const Pair> pairs, const Arena& arena) {
  const Groups<Index> neighbours = neighbours_in(sites.count(), pairs, arena);
  const int dimension = metric.dimension();
  struct Neighbour {
    double squared;
    Index site;
    std::size_t offset;
  };
  struct Scratch {
    std::vector<Neighbour> nearest_first;
    std::vector<double> offsets;
  };
  PerWorker<Scratch> scratch(arena);
  const auto keep = [&](Index a, Scratch& own, std::vector<Pair>& kept) {
    own.nearest_first.clear();
    own.offsets.clear();
    for (const Index b : neighbours[static_cast<std::size_t>(a)]) {
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
        for (std::size_t d = 0; d < static_cast<std::size_t>(dimension); ++d) {
          along += own.offsets[other.offset + d] * own.offsets[next->offset + d];
        }
        return other.squared < along;
      };
      if (std::none_of(own.nearest_first.begin(), next, between)) kept.emplace_back(a, next->site);
    }
  };
  return collect<Pair>(arena, neighbours.count(), kSitesPerGrain,
                       [&](std::size_t begin, std::size_t end, std::vector<Pair>& kept, int w) {
                         for (std::size_t a = begin; a < end; ++a) {
                           keep(static_cast<Index>(a), scratch[w], kept);
                         }
                       });
}

SiteGraph::SiteGraph(Index sites, std::span<const Pair> edges, const Arena& arena)
    : neighbours_(neighbours_in(sites, edges, arena)), tree_(neighbours_, arena) {
  if (tree_.size() == neighbours_.count()) return;
  std::vector<Pair> all(edges.begin(), edges.end());
  DisjointSets sets(sites);
  for (const auto& [a, b] : edges) sets.join(a, b);
  for (Index s = 0; s + 1 < sites; ++s) {
    if (sets.join(s, s + 1)) all.emplace_back(s, s + 1);
  }
  neighbours_ = neighbours_in(sites, all, arena);
  tree_ = SpanningTree(neighbours_, arena);
}

}  // namespace ccvt
