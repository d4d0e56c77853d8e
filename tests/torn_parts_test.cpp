// Which cells are torn, and which sites are looked at to mend them.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "geometry/metric.h"
#include "random.h"
#include "relax/level_state.h"
#include "relax/relaxer.h"
#include "relax/update.h"
#include "spatial/site_tree.h"
#include "torn/mend.h"
#include "torn/torn_sites.h"
#include "torn/windows.h"

using ccvt::Arena;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Index;
using ccvt::LevelState;
using ccvt::Metric;
using ccvt::PointOfAll;
using ccvt::Random;
using ccvt::SiteNumber;
using ccvt::SiteState;
using ccvt::SiteTree;
using ccvt::TornSite;
using ccvt::Window;

namespace {

constexpr Index kCapacity = 32;

struct Place {
  double x, y;
};
struct Places {
  Place first, second;
};

/// Cells of points at two places each, with a little noise; a quarter of them at the second.
LevelState<double> state_of(const Metric& metric, const std::vector<Places>& where,
                            double noise = 0.01) {
  const std::vector<Index> capacities(where.size(), kCapacity);
  LevelState<double> state{ccvt::Tiling(where.size(), 4), SiteState(2, where.size()),
                           Cells<double>(2, capacities)};
  Random random(3);
  Index number = 0;
  for (const SiteNumber s : state.sites.all()) {
    for (Index k = 0; k < kCapacity; ++k) {
      const Place& place = k < 3 * kCapacity / 4 ? where[s].first : where[s].second;
      const double x[] = {place.x + noise * random.uniform(), place.y + noise * random.uniform()};
      state.cells.put(s, k, PointOfAll(number++), x);
    }
  }
  ccvt::update_all(metric, state, Arena(1));
  return state;
}

/// Sites in rows, next to each other.
SiteState rows(Index columns, Index count) {
  SiteState sites(2, columns * count);
  for (const SiteNumber s : sites.all()) {
    sites.at(s)[0] = s.index() % columns;
    const Index row = s.index() / columns;
    sites.at(s)[1] = row;
  }
  return sites;
}

std::vector<TornSite> torn_in(const Metric& metric, const LevelState<double>& state,
                              int threads = 1) {
  const SiteTree tree(metric, state.sites.position);
  return ccvt::torn_sites(metric, state, tree, Arena(threads));
}

bool has(const Window& window, Index site) {
  return std::binary_search(window.begin(), window.end(), SiteNumber(site));
}

}  // namespace

TEST_SUITE_BEGIN("torn parts");

TEST_CASE("a cell is torn whose points are nearer to other sites") {
  const Metric metric(2, Domain());
  // Cell 4 has points at sites 0 and 1, and at 2 and 3; all others are whole.
  const LevelState<double> state = state_of(metric, {{{0, 0}, {0, 0.1}},
                                                     {{0.1, 0}, {0.1, 0.1}},
                                                     {{1, 0}, {1, 0.1}},
                                                     {{1.1, 0}, {1.1, 0.1}},
                                                     {{0.05, 0.05}, {1.05, 0.05}}});
  const std::vector<TornSite> torn = torn_in(metric, state, 2);
  REQUIRE(torn.size() == 1);
  CHECK(torn[0].site == SiteNumber(4));
  CHECK(torn[0].excess == doctest::Approx(24 * 0.06 + 8 * 0.56).epsilon(0.1));
  for (const SiteNumber near : torn[0].nearest) CHECK(near != SiteNumber(4));
  CHECK(torn[0].nearest.size() >= 2);
  CHECK(std::is_sorted(torn[0].nearest.begin(), torn[0].nearest.end()));
}

TEST_CASE("no cell is torn of one site, nor of sites in one place") {
  const Metric metric(2, Domain());
  CHECK(torn_in(metric, state_of(metric, {{{0, 0}, {1, 1}}})).empty());
  const std::vector<Places> same(5, {{0, 0}, {0, 0}});
  CHECK(torn_in(metric, state_of(metric, same, 0)).empty());
}

TEST_CASE("three cells that are torn around in a circle are mended") {
  const Metric metric(2, Domain());
  const Place a{0, 0};
  const Place b{1, 0};
  const Place c{0.5, std::sqrt(0.75)};
  LevelState<double> state = state_of(metric, {{a, b}, {b, c}, {c, a}, {a, a}, {b, b}, {c, c}});
  const std::vector<TornSite> torn = torn_in(metric, state);
  CHECK(torn.size() == 3);
  const std::vector<Window> windows =
      ccvt::windows_around(state.sites, SiteTree(metric, state.sites.position), state.cells.sizes(),
                           torn, {100, 10000, 10000, 1e6});
  REQUIRE(windows.size() == 1);
  REQUIRE(windows[0].size() == 6);
  const double before = ccvt::total_energy(state.sites);
  const LevelState<double> old = state;
  std::vector<ccvt::Unmended<double>> undo;
  const double gain = ccvt::mend(metric, windows[0], state, Arena(1), undo);
  CHECK(gain == doctest::Approx(before - ccvt::total_energy(state.sites)));
  CHECK(ccvt::total_energy(state.sites) < 0.01 * before);
  const double told = ccvt::total_energy(state.sites);
  ccvt::update_all(metric, state, Arena(1));
  CHECK(ccvt::total_energy(state.sites) == doctest::Approx(told));
  CHECK(torn_in(metric, state).empty());
  const SiteState mended = state.sites;
  CHECK(ccvt::mend(metric, windows[0], state, Arena(1), undo) == 0);
  CHECK(state.sites.position == mended.position);
  REQUIRE(undo.size() == 1);
  ccvt::restore(undo, state);
  CHECK(undo.empty());
  CHECK(state.sites.position == old.sites.position);
  CHECK(state.sites.energy == old.sites.energy);
  CHECK(state.sites.radius == old.sites.radius);
  for (const SiteNumber s : state.sites.all()) {
    for (Index k = 0; k < kCapacity; ++k) {
      CHECK(state.cells.point(s, k) == old.cells.point(s, k));
      double now[2];
      double then[2];
      state.cells.get(s, k, now);
      old.cells.get(s, k, then);
      CHECK((now[0] == then[0] && now[1] == then[1]));
    }
  }
}

TEST_CASE("a window links what is near the points of torn sites") {
  const Metric metric(2, Domain());
  constexpr Index kColumns = 100;
  const SiteState sites = rows(kColumns, 20);
  const SiteTree tree(metric, sites.position);
  const std::vector<Index> capacities(sites.count(), 16);
  const Index left = 5 * kColumns + 20;
  const Index right = 5 * kColumns + 60;
  const std::vector<TornSite> torn{{SiteNumber(0), 1, {SiteNumber(left), SiteNumber(right)}}};
  const std::vector<Window> windows =
      ccvt::windows_around(sites, tree, capacities, torn, {512, 1 << 16, 1 << 16, 1e6});
  REQUIRE(windows.size() == 1);
  const Window& window = windows[0];
  CHECK(std::is_sorted(window.begin(), window.end()));
  CHECK(std::adjacent_find(window.begin(), window.end()) == window.end());
  CHECK(has(window, 0));
  for (Index x = 20; x <= 60; ++x) {  // some site of each column between them
    bool any = false;
    for (Index y = 0; y < 20; ++y) any = any || has(window, y * kColumns + x);
    CHECK(any);
  }
  CHECK(has(window, left - kColumns));  // and what lies beside
  CHECK_FALSE(has(window, 1));          // not what is next to the torn one
  CHECK(window.size() >= 128);
  CHECK(window.size() <= 512);
}

TEST_CASE("windows have no more sites than they may, and each torn site is in one") {
  const Metric metric(2, Domain());
  const SiteState sites = rows(50, 50);
  const SiteTree tree(metric, sites.position);
  std::vector<TornSite> torn;
  for (Index s = 0; s < 2500; s += 7) {
    torn.push_back({SiteNumber(s), 1, {SiteNumber(2499 - s), SiteNumber((s + 1250) % 2500)}});
  }
  std::vector<Index> capacities(2500, 16);
  for (std::size_t s = 0; s < capacities.size(); s += 11) capacities[s] = 5000;
  for (const std::size_t most : std::vector<std::size_t>{64, 100, 512}) {
    const auto windows_of = [&](double work) {
      return ccvt::windows_around(sites, tree, capacities, torn, {most, 10000, 4000, work});
    };
    const std::vector<Window> windows = windows_of(1e9);
    CHECK(windows.size() > 1);
    std::vector<int> covered(2500, 0);
    for (const Window& window : windows) {
      CHECK(window.size() <= most);
      Index points = 0;
      for (const SiteNumber s : window) {
        covered[s] = 1;
        points += capacities[s];
      }
      CHECK(points <= 10000);
    }
    for (const TornSite& t : torn) CHECK(covered[t.site] == (capacities[t.site] == 16 ? 1 : 0));
    CHECK(windows_of(1) == std::vector<Window>{windows[0]});
  }
  CHECK(ccvt::windows_around(sites, tree, capacities, {}, {512, 10000, 4000, 1e9}).empty());
}

TEST_SUITE_END();
