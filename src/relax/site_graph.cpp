#include "relax/site_graph.h"

#include <algorithm>
#include <cmath>
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

std::vector<Pair> gabriel_pairs(const Metric& metric, const SiteState& sites,
                                std::span<const Pair> pairs) {
  const SiteGraph graph(sites.count(), pairs);
  std::vector<Pair> kept;
  std::vector<std::pair<double, Index>> nearest_first;
  for (Index a = 0; a < sites.count(); ++a) {
    nearest_first.clear();
    for (const Index b : graph.neighbours(a)) {
      nearest_first.emplace_back(metric.squared_distance(sites.at(a), sites.at(b)), b);
    }
    std::sort(nearest_first.begin(), nearest_first.end());
    for (auto next = nearest_first.begin(); next != nearest_first.end(); ++next) {
      const auto [length, b] = *next;
      if (b < a) continue;
      const auto between = [&, length = length, b = b](const std::pair<double, Index>& other) {
        const auto& [squared, k] = other;
        return squared + metric.squared_distance(sites.at(b), sites.at(k)) < length;
      };
      if (std::none_of(nearest_first.begin(), next, between)) kept.emplace_back(a, b);
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

std::vector<double> SiteGraph::potential(std::span<const Index> e) const {
  constexpr double kResidual = 0.25;
  const std::size_t n = e.size();
  std::vector<double> phi(n, 0.0);
  if (n < 2) return phi;
  std::vector<double> residual(e.begin(), e.end());
  std::vector<double> direction(n, 0.0);
  std::vector<double> image(n);
  std::vector<double> inverse_degree(n);
  for (std::size_t s = 0; s < n; ++s) {
    inverse_degree[s] = 1 / static_cast<double>(begin_[s + 1] - begin_[s]);
  }
  double rho = 0;
  double largest = 0;
  const auto measure = [&](std::size_t s) {
    rho += residual[s] * residual[s] * inverse_degree[s];
    largest = std::max(largest, std::abs(residual[s]));
  };
  for (std::size_t s = 0; s < n; ++s) measure(s);
  double beta = 0;
  for (std::size_t iteration = 0; iteration < 2 * n && largest > kResidual; ++iteration) {
    for (std::size_t s = 0; s < n; ++s) {
      direction[s] = residual[s] * inverse_degree[s] + beta * direction[s];
    }
    double curvature = 0;
    for (std::size_t s = 0; s < n; ++s) {
      double sum = static_cast<double>(begin_[s + 1] - begin_[s]) * direction[s];
      for (std::size_t k = begin_[s]; k < begin_[s + 1]; ++k) {
        sum -= direction[static_cast<std::size_t>(neighbour_[k])];
      }
      image[s] = sum;
      curvature += direction[s] * sum;
    }
    if (!(curvature > 0)) break;  // nothing left but rounding
    const double step = rho / curvature;
    const double before = rho;
    rho = 0;
    largest = 0;
    for (std::size_t s = 0; s < n; ++s) {
      phi[s] += step * direction[s];
      residual[s] -= step * image[s];
      measure(s);
    }
    beta = rho / before;
  }
  return phi;
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
