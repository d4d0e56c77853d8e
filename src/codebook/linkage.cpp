#include "codebook/linkage.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>

#include "ccvt/types.h"
#include "exact/neighbourhoods.h"
#include "exact/packs.h"
#include "kernels/nearest.h"

namespace ccvt {
namespace {

/// The most sites of a group, where there are too many to be linked all together: there are far
/// fewer groups than sites.
constexpr std::size_t kGroupSites = 64;

struct Edge {
  double squared;
  SiteNumber a, b;
};

/// The edges of the minimum spanning tree of all sites [Prim 1957]. O(n^2 D).
std::vector<Edge> spanning_edges(std::span<const double> sites, int dimension, const Arena& arena) {
  const auto width = static_cast<std::size_t>(dimension);
  const std::size_t n = sites.size() / width;
  const std::vector<double> packs = packs_of(sites, width);
  std::vector<double> squared(packs.size() / width);
  std::vector<double> nearest(n, std::numeric_limits<double>::infinity());
  std::vector<SiteNumber> neighbour(n, SiteNumber(0));
  std::vector<std::uint8_t> inside(n, 0);
  std::vector<Edge> edges;
  SiteNumber last(0);
  while (edges.size() + 1 < n) {
    arena.check();
    inside[last] = 1;
    kernels::squared_distances(sites.data() + last * width, packs.data(),
                               static_cast<Index>(squared.size()) / kernels::kPack, dimension,
                               nullptr, squared.data());
    SiteNumber next = SiteNumber::none();
    for (const SiteNumber s : sites_below(n)) {
      if (inside[s] != 0) continue;
      if (squared[s] < nearest[s]) {
        nearest[s] = squared[s];
        neighbour[s] = last;
      }
      if (next == SiteNumber::none() || nearest[s] < nearest[next]) next = s;
    }
    edges.push_back({nearest[next], neighbour[next], next});
    last = next;
  }
  return edges;
}

/// All sites, such that every set that single linkage ever joins stands together.
std::vector<SiteNumber> ordered_by(std::vector<Edge> edges) {
  std::stable_sort(edges.begin(), edges.end(),
                   [](const Edge& a, const Edge& b) { return a.squared < b.squared; });
  const std::size_t n = edges.size() + 1;
  // Sets as chains, known by their first site.
  std::vector<SiteNumber> first(n), last(n), next(n, SiteNumber::none());
  std::iota(first.begin(), first.end(), SiteNumber(0));
  last = first;
  const auto find = [&](SiteNumber s) {
    while (first[s] != s) s = first[s] = first[first[s]];
    return s;
  };
  for (const Edge& edge : edges) {
    const SiteNumber a = find(edge.a);
    const SiteNumber b = find(edge.b);
    next[last[a]] = b;
    last[a] = last[b];
    first[b] = a;
  }
  std::vector<SiteNumber> order;
  for (SiteNumber s = find(SiteNumber(0)); s != SiteNumber::none(); s = next[s]) order.push_back(s);
  return order;
}

}  // namespace

std::vector<SiteNumber> linkage_order(std::span<const double> sites, int dimension,
                                      const Arena& arena) {
  const auto width = static_cast<std::size_t>(dimension);
  if (sites.size() / width <= kLinkedTogether) {
    return ordered_by(spanning_edges(sites, dimension, arena));
  }
  const Neighbourhoods near(sites, width, kGroupSites, arena);
  std::vector<std::vector<SiteNumber>> linked(near.count());
  arena.for_each(near.count(), 1, [&](std::size_t g) {
    const auto group = near.of(g);
    std::vector<double> own;
    own.reserve(group.size() * width);
    for (const SiteNumber s : group) {
      own.insert(own.end(), sites.data() + s * width, sites.data() + (s + 1) * width);
    }
    for (const SiteNumber k : ordered_by(spanning_edges(own, dimension, arena))) {
      linked[g].push_back(group[k]);
    }
  });
  std::vector<SiteNumber> order;
  for (const SiteNumber g : linkage_order(near.means(sites, width), dimension, arena)) {
    order.insert(order.end(), linked[g].begin(), linked[g].end());
  }
  return order;
}

}  // namespace ccvt
