// The potential that the start's flow follows: it solves the Laplacian of any connected graph.
#include "relax/potential.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "random.h"
#include "relax/site_graph.h"

using ccvt::Index;
using ccvt::Pair;
using ccvt::Random;
using ccvt::SiteGraph;
using ccvt::SiteNumber;

namespace {

std::vector<Pair> path(Index nodes) {
  std::vector<Pair> edges;
  for (Index s = 0; s + 1 < nodes; ++s) edges.emplace_back(s, s + 1);
  return edges;
}

std::vector<Pair> grid(Index width, Index height) {
  std::vector<Pair> edges;
  for (Index y = 0; y < height; ++y) {
    for (Index x = 0; x < width; ++x) {
      if (x + 1 < width) edges.emplace_back(y * width + x, y * width + x + 1);
      if (y + 1 < height) edges.emplace_back(y * width + x, (y + 1) * width + x);
    }
  }
  return edges;
}

std::vector<Pair> star(Index nodes) {
  std::vector<Pair> edges;
  for (Index s = 1; s < nodes; ++s) edges.emplace_back(0, s);
  return edges;
}

std::vector<Pair> random_edges(Index nodes, Index count) {
  Random random(7, 1);
  std::vector<Pair> edges;
  for (Index k = 0; k < count; ++k) {
    const auto a = static_cast<Index>(random.below(static_cast<std::uint64_t>(nodes)));
    const auto b = static_cast<Index>(random.below(static_cast<std::uint64_t>(nodes)));
    if (a != b) edges.emplace_back(std::min(a, b), std::max(a, b));
  }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// Surpluses that sum to zero: random ones, or all in the first and lacking in the last.
std::vector<Index> surpluses(std::size_t nodes, bool far) {
  std::vector<Index> e(nodes, 0);
  if (far) {
    e.front() += 1000;
    e.back() -= 1000;
    return e;
  }
  Random random(5, 1);
  for (Index& x : e) x = static_cast<Index>(random.below(41)) - 20;
  e.back() -= std::accumulate(e.begin(), e.end(), 0);
  return e;
}

void check_solved(const SiteGraph& graph, const std::vector<Index>& e) {
  const std::vector<double> phi = ccvt::potential(graph, e);
  REQUIRE(phi.size() == e.size());
  for (const SiteNumber s : ccvt::sites_below(graph.site_count())) {
    double out = 0;
    for (const SiteNumber t : graph.neighbours(s)) out += phi[s] - phi[t];
    // The residual is followed, not computed anew: rounding adds a little.
    REQUIRE(std::abs(out - e[s]) <= 0.2501);
  }
}

}  // namespace

TEST_SUITE_BEGIN("potential");

TEST_CASE("L phi = e, on graphs of all kinds") {
  const std::vector<std::pair<std::string, SiteGraph>> graphs = {
      {"one", {1, {}}},
      {"two", {2, path(2)}},
      {"path", {3000, path(3000)}},
      {"grid", {120 * 90, grid(120, 90)}},
      {"star", {2000, star(2000)}},
      {"random", {5000, random_edges(5000, 15000)}},
      {"parts", {5000, random_edges(5000, 1500)}},
      {"edgeless", {500, {}}}};
  for (const auto& named : graphs) {
    const SiteGraph& graph = named.second;
    CAPTURE(named.first);
    for (const bool far : {false, true}) {
      check_solved(graph, surpluses(graph.site_count(), far && graph.site_count() > 1));
    }
    const auto nothing = ccvt::potential(graph, std::vector<Index>(graph.site_count(), 0));
    CHECK(std::all_of(nothing.begin(), nothing.end(), [](double x) { return x == 0; }));
  }
}

TEST_SUITE_END();
