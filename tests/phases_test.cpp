// The phases of the solver, each by itself: against brute force, and the same for any threads.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <numeric>
#include <set>
#include <span>
#include <type_traits>
#include <vector>

#include "random.h"
#include "relax/all_pairs.h"
#include "relax/balance.h"
#include "relax/meeting_pairs.h"
#include "relax/site_graph.h"
#include "relax/site_order.h"
#include "support/generate.h"
#include "support/thread_ranks.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Buffer;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::Pair;
using ccvt::PointNumber;
using ccvt::PointOfAll;
using ccvt::Random;
using ccvt::SiteGraph;
using ccvt::SiteNumber;
using ccvt::SiteState;
using ccvt::SpanningTree;
using ccvt::Tile;
using ccvt::Tiling;
using namespace ccvt::test;

namespace {

SiteState make_sites(Layout layout, const Box& box, Index count) {
  const auto places = make_points<double>(layout, box, count, 3);
  SiteState sites(box.dimension(), count);
  std::copy_n(places.data(), places.size(), sites.position.begin());
  return sites;
}

std::vector<Pair> all_pairs_of(Index count) {
  std::vector<Pair> pairs;
  for (Index i = 0; i < count; ++i) {
    for (Index j = i + 1; j < count; ++j) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace

TEST_SUITE_BEGIN("phases");

// Numbers of different kinds do not become each other, nor do integers become numbers by
// themselves.
static_assert(sizeof(SiteNumber) == 4 && std::is_trivially_copyable_v<SiteNumber>);
static_assert(!std::is_constructible_v<PointNumber, SiteNumber>);
static_assert(!std::is_constructible_v<PointOfAll, PointNumber>);
static_assert(!std::is_constructible_v<Tile, SiteNumber>);
static_assert(!std::is_convertible_v<Index, SiteNumber>);
static_assert(std::is_convertible_v<SiteNumber, std::size_t>);

TEST_CASE("tiles cover the sites in runs, and hold no more points than fit the cache") {
  for (const Index sites : {1, 5, 64, 65, 1000}) {
    for (const Index most : {1, 7, 64, 2000}) {
      const Tiling tiling(sites, most);
      SiteNumber next;
      for (const Tile tile : ccvt::numbers_below<Tile>(tiling.count())) {
        std::size_t size = 0;
        for (const SiteNumber site : tiling.sites_of(tile)) {
          CHECK(site == next);
          CHECK(tiling.tile_of(site) == tile);
          ++next;
          ++size;
        }
        CHECK(size == tiling.sites_of(tile).size());
        CHECK((size > 0 && size <= static_cast<std::size_t>(most)));
      }
      CHECK(next == SiteNumber(sites));
    }
  }
  CHECK(Tiling::of_points(1000, 256000, 64).sites_per_tile() == 64);
  CHECK(Tiling::of_points(1000, 16384000, 64).sites_per_tile() == 4);
  CHECK(Tiling::of_points(10, 1 << 30, 64).sites_per_tile() == 1);
}

TEST_CASE("the spatial order is a permutation whose runs lie apart") {
  for (const int dimension : {1, 2, 3}) {
    const Box box = uneven_box(dimension);
    for (const Layout layout : all_layouts) {
      for (const Index count : {1, 2, 3, 64, 100, 1000}) {
        const SiteState sites = make_sites(layout, box, count);
        const auto order = ccvt::spatial_order(sites, 16);
        CHECK(order == ccvt::spatial_order(sites, 16, Arena(3)));
        for (const int ranks : {1, 2, 5}) {
          std::vector<std::vector<SiteNumber>> of_ranks(static_cast<std::size_t>(ranks));
          ThreadRanks(ranks).run([&](ccvt::Ranks& own) {
            Arena arena(2);
            arena.divide_among(&own);
            of_ranks[static_cast<std::size_t>(own.rank())] = ccvt::spatial_order(sites, 16, arena);
          });
          for (const auto& same : of_ranks) CHECK(same == order);
        }
        std::vector<SiteNumber> sorted(order);
        std::sort(sorted.begin(), sorted.end());
        for (const SiteNumber k : sites.all()) REQUIRE(sorted[k] == k);
        if (layout != Layout::random) continue;
        // Of two runs of four sites there is a dimension along which they do not overlap.
        const auto range = [&](std::size_t run, int d) {
          double low = INFINITY;
          double high = -INFINITY;
          for (std::size_t k = 4 * run; k < std::min(4 * run + 4, order.size()); ++k) {
            low = std::min(low, sites.at(order[k])[d]);
            high = std::max(high, sites.at(order[k])[d]);
          }
          return std::pair(low, high);
        };
        const std::size_t runs = (order.size() + 3) / 4;
        for (std::size_t a = 0; a < runs; ++a) {
          for (std::size_t b = a + 1; b < runs; ++b) {
            bool apart = false;
            for (int d = 0; d < dimension; ++d) {
              const auto x = range(a, d);
              const auto y = range(b, d);
              apart = apart || x.second < y.first || y.second < x.first;
            }
            REQUIRE(apart);
          }
        }
      }
    }
  }
}

TEST_CASE("all pairs come once, and no site twice in a batch") {
  for (const Index sites : {1, 2, 9, 64, 130}) {
    for (const Index tile : {1, 8, 64}) {
      ccvt::AllPairs all({sites, tile});
      std::vector<Pair> seen;
      for (std::size_t b = 0; b < all.batch_count(); ++b) {
        std::set<Tile> tiles;
        for (const auto& task : all.batch(b)) {
          CHECK(tiles.insert(task.a).second);
          if (task.a != task.b) CHECK(tiles.insert(task.b).second);
          all.for_pairs(task, [&](SiteNumber i, SiteNumber j) { seen.emplace_back(i, j); });
        }
      }
      std::sort(seen.begin(), seen.end());
      CHECK(seen == all_pairs_of(sites));
    }
  }
}

TEST_CASE("Gabriel pairs are those whose ball is empty") {
  for (const int dimension : {1, 2, 3}) {
    const Box box = uneven_box(dimension);
    const SiteState sites = make_sites(Layout::random, box, 60);
    const Metric metric(dimension, Domain());
    std::vector<Pair> expected;
    for (const auto& [a, b] : all_pairs_of(60)) {
      std::vector<double> middle(static_cast<std::size_t>(dimension));
      for (int d = 0; d < dimension; ++d) {
        middle[static_cast<std::size_t>(d)] = (sites.at(a)[d] + sites.at(b)[d]) / 2;
      }
      const double squared = metric.squared_distance(sites.at(a), sites.at(b)) / 4;
      bool empty = true;
      for (const SiteNumber k : sites.all()) {
        if (k != a && k != b && metric.squared_distance(sites.at(k), middle.data()) < squared) {
          empty = false;
        }
      }
      if (empty) expected.emplace_back(a, b);
    }
    for (const int threads : {1, 3}) {
      auto found = ccvt::gabriel_pairs(metric, sites, all_pairs_of(60), {60, 1}, Arena(threads));
      std::sort(found.begin(), found.end());
      CHECK(std::equal(found.begin(), found.end(), expected.begin(), expected.end()));
    }
  }
}

TEST_CASE("a graph of sites is connected, and its tree spans it") {
  Random random(4);
  for (const Index edges : {0, 20, 300}) {
    std::set<Pair> drawn;
    while (static_cast<Index>(drawn.size()) < edges) {
      const auto a = static_cast<Index>(random.below(100));
      const auto b = static_cast<Index>(random.below(100));
      if (a != b) drawn.emplace(std::min(a, b), std::max(a, b));
    }
    const SiteGraph graph(100, std::vector<Pair>(drawn.begin(), drawn.end()));
    for (const auto& [a, b] : drawn) {
      const auto of_a = graph.neighbours(a);
      const auto of_b = graph.neighbours(b);
      CHECK(std::binary_search(of_a.begin(), of_a.end(), b));
      CHECK(std::binary_search(of_b.begin(), of_b.end(), a));
    }
    const auto& tree = graph.spanning_tree();
    REQUIRE(tree.size() == 100);
    std::set<SiteNumber> seen;
    for (const SiteNumber s : tree.order()) {
      const SiteNumber parent = tree.parent(s);
      CHECK((parent == SiteNumber::none()) == seen.empty());
      if (parent != SiteNumber::none()) {
        CHECK(seen.count(parent) == 1);
        const auto near = graph.neighbours(s);
        CHECK(std::binary_search(near.begin(), near.end(), parent));
      }
      CHECK(seen.insert(s).second);
    }
  }
}

TEST_CASE("a spanning tree of many blocks: parents, sums of subtrees, the same for any threads") {
  constexpr Index kNodes = 5000;  // five blocks
  Random random(7);
  for (const bool connected : {true, false}) {
    std::vector<Pair> edges;
    for (Index s = 1; s < kNodes; ++s) {
      // To one before it, most of them near; else some parts stay apart.
      const Index back = 1 + static_cast<Index>(random.below(s % 50 == 0 ? 4000 : 40));
      if (s - back >= 0 || connected) edges.emplace_back(std::max(s - back, 0), s);
    }
    const SiteGraph joined(kNodes, edges);
    const SpanningTree& tree = joined.spanning_tree();
    REQUIRE(tree.size() == kNodes);
    const std::vector<SiteNumber> order = tree.order();
    std::vector<bool> seen(kNodes, false);
    for (const SiteNumber s : order) {
      CHECK_FALSE(seen[s]);
      seen[s] = true;
      const SiteNumber parent = tree.parent(s);
      if (s == order[0]) {
        CHECK(parent == SiteNumber::none());
      } else {
        REQUIRE(parent < seen.size());
        CHECK(seen[parent]);
        const auto near = joined.neighbours(s);
        CHECK(std::binary_search(near.begin(), near.end(), parent));
      }
    }
    std::vector<std::int64_t> values(kNodes);
    for (auto& v : values) v = static_cast<std::int64_t>(random.below(2001)) - 1000;
    std::vector<std::int64_t> expected = values;
    for (std::size_t k = order.size(); k-- > 1;) {
      expected[tree.parent(order[k])] += expected[order[k]];
    }
    for (const int threads : {1, 2, 3, 8}) {
      const Arena arena(threads);
      const SpanningTree again(joined.all_neighbours(), arena);
      CHECK(again.order() == order);
      std::vector<std::int64_t> sums = values;
      again.add_subtrees(sums, arena);
      CHECK(sums == expected);
    }
  }
}

TEST_CASE("every pair that meets is listed, as spheres move and grow") {
  for (const bool periodic : {false, true}) {
    for (const int dimension : {2, 3, 6}) {
      CAPTURE(periodic);
      CAPTURE(dimension);
      const Box box = uneven_box(dimension);
      const Metric metric(dimension, periodic ? Domain::periodic(box) : Domain());
      constexpr Index kSites = 200;
      SiteState sites = make_sites(Layout::random, box, kSites);
      for (double& radius : sites.radius) radius = 0.4 * std::pow(1.0 / kSites, 1.0 / dimension);
      ccvt::MeetingPairs meeting;
      Random random(11, static_cast<std::uint64_t>(dimension));
      bool extended = false;
      for (int pass = 0; pass < 12; ++pass) {
        const auto done = meeting.refresh(metric, sites, {kSites, 1}, Arena(1 + pass % 3), 1 << 20);
        REQUIRE(done != ccvt::MeetingPairs::Refreshed::too_many);
        extended = extended || done == ccvt::MeetingPairs::Refreshed::extended;
        std::set<Pair> listed(meeting.pairs().begin(), meeting.pairs().end());
        CHECK(listed.size() == meeting.pairs().size());
        listed.insert(meeting.added().begin(), meeting.added().end());
        CHECK(listed.size() == meeting.pairs().size() + meeting.added().size());
        for (const auto& [i, j] : all_pairs_of(kSites)) {
          const double reach = sites.radius[i] + sites.radius[j];
          if (metric.squared_distance(sites.at(i), sites.at(j)) <= reach * reach) {
            REQUIRE(listed.count({i, j}) == 1);
          }
        }
        // A few sites go far, or grow.
        for (int k = 0; k < 4; ++k) {
          const SiteNumber s(random.below(kSites));
          for (int d = 0; d < dimension; ++d) {
            sites.at(s)[d] = metric.into_box(sites.at(s)[d] + 0.1 * (random.uniform() - 0.5), d);
          }
          sites.radius[s] *= 1 + random.uniform();
        }
      }
      CHECK(extended);
      meeting.forget();
      CHECK(meeting.refresh(metric, sites, {kSites, 1}, Arena(1), 10) ==
            ccvt::MeetingPairs::Refreshed::too_many);
    }
  }
}

TEST_CASE("balance fills every cell, whatever flows, with the same bits for any threads") {
  for (const Layout layout : all_layouts) {
    for (const auto& capacities :
         {std::vector<Index>(150, 8), unequal_capacities(60), std::vector<Index>(200, 1)}) {
      // All points with the first site, or with random ones.
      for (const bool far : {true, false}) {
        CAPTURE(name_of(layout));
        CAPTURE(far);
        const Box box = uneven_box(2);
        const Metric metric(2, Domain());
        const auto count = static_cast<Index>(capacities.size());
        const SiteState sites = make_sites(layout, box, count);
        const auto points = make_points<float>(layout, box, sum_of(capacities), 8);
        const auto view = ccvt::view_points(points);
        std::vector<Pair> near;
        for (Index s = 0; s + 1 < count; ++s) near.emplace_back(s, s + 1);
        std::vector<PointOfAll> expected;
        for (const int threads : {1, 2, 3, 8}) {
          ccvt::Cells<float> cells(2, capacities);
          ccvt::Filling<float> filling(cells, view, Tiling(count, 16));
          Random random(2);
          for (const PointNumber p : ccvt::points_below(points.cols())) {
            const SiteNumber site(random.below(static_cast<std::uint64_t>(count)));
            filling.add(far ? SiteNumber(0) : site, p);
          }
          ccvt::balance(metric, sites, near, Arena(threads), filling);
          std::vector<PointOfAll> order;
          for (const SiteNumber s : cells.sites()) {
            REQUIRE(filling.surplus(s) == 0);
            REQUIRE(filling.waiting(s) == 0);
            const auto held = cells.points(s);
            order.insert(order.end(), held.begin(), held.end());
          }
          if (threads == 1) {
            std::vector<PointOfAll> sorted(order);
            std::sort(sorted.begin(), sorted.end());
            for (const PointNumber p : ccvt::points_below(points.cols())) {
              REQUIRE(sorted[p] == PointOfAll(p.index()));
            }
            expected = order;
          }
          CHECK(order == expected);
        }
      }
    }
  }
}

TEST_SUITE_END();
