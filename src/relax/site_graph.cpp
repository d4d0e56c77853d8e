#include "relax/site_graph.h"

#include <algorithm>
#include <cstdint>
#include <numeric>

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

}  // namespace

/// With a as the origin, k is in the diametral ball of a and b when |k|^2 < k . b.
std::vector<Pair> gabriel_pairs(const Metric& metric, const SiteState& sites,
                                std::span<const Pair> pairs) {
  const SiteGraph graph(sites.count(), pairs);
  const int dimension = metric.dimension();
  struct Neighbour {
    double squared;
    Index site;
    std::size_t offset;
  };
  std::vector<Pair> kept;
  std::vector<Neighbour> nearest_first;
  std::vector<double> offsets;
  for (Index a = 0; a < sites.count(); ++a) {
    nearest_first.clear();
    offsets.clear();
    for (const Index b : graph.neighbours(a)) {
      nearest_first.push_back({0, b, offsets.size()});
      for (int d = 0; d < dimension; ++d) {
        offsets.push_back(metric.wrap(sites.at(b)[d] - sites.at(a)[d], d));
        nearest_first.back().squared += offsets.back() * offsets.back();
      }
    }
    std::sort(nearest_first.begin(), nearest_first.end(), [](const auto& x, const auto& y) {
      return x.squared != y.squared ? x.squared < y.squared : x.site < y.site;
    });
    for (auto next = nearest_first.begin(); next != nearest_first.end(); ++next) {
      if (next->site < a) continue;
      const auto between = [&](const Neighbour& other) {
        double along = 0;
        for (std::size_t d = 0; d < static_cast<std::size_t>(dimension); ++d) {
          along += offsets[other.offset + d] * offsets[next->offset + d];
        }
        return other.squared < along;
      };
      if (std::none_of(nearest_first.begin(), next, between)) kept.emplace_back(a, next->site);
    }
  }
  return kept;
}

SiteGraph::SiteGraph(Index sites, std::span<const Pair> edges) {
  std::vector<Pair> all(edges.begin(), edges.end());
  DisjointSets sets(sites);
  for (const auto& [a, b] : edges) sets.join(a, b);
  for (Index s = 0; s + 1 < sites; ++s) {
    if (sets.join(s, s + 1)) all.emplace_back(s, s + 1);
  }
  begin_.assign(static_cast<std::size_t>(sites) + 1, 0);
  for (const auto& [a, b] : all) {
    ++begin_[static_cast<std::size_t>(a) + 1];
    ++begin_[static_cast<std::size_t>(b) + 1];
  }
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  neighbour_.resize(begin_.back());
  std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
  for (const auto& [a, b] : all) {
    neighbour_[next[static_cast<std::size_t>(a)]++] = b;
    neighbour_[next[static_cast<std::size_t>(b)]++] = a;
  }
  for (std::size_t s = 0; s + 1 < begin_.size(); ++s) {
    std::sort(neighbour_.begin() + static_cast<std::ptrdiff_t>(begin_[s]),
              neighbour_.begin() + static_cast<std::ptrdiff_t>(begin_[s + 1]));
  }
}

SiteGraph::SpanningTree SiteGraph::spanning_tree() const {
  SpanningTree tree;
  const auto n = static_cast<std::size_t>(site_count());
  tree.parent.assign(n, -1);
  std::vector<std::uint8_t> seen(n, 0);
  tree.order.reserve(n);
  tree.order.push_back(0);
  seen[0] = 1;
  for (std::size_t k = 0; k < tree.order.size(); ++k) {
    for (const Index t : neighbours(tree.order[k])) {
      if (seen[static_cast<std::size_t>(t)] != 0) continue;
      seen[static_cast<std::size_t>(t)] = 1;
      tree.parent[static_cast<std::size_t>(t)] = tree.order[k];
      tree.order.push_back(t);
    }
  }
  return tree;
}

}  // namespace ccvt
