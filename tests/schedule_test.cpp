// Schedules and levels: who is examined when, and who joins when.
#include "schedule/schedule.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <numeric>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "random.h"
#include "relax/levels.h"
#include "support/generate.h"

using ccvt::Batches;
using ccvt::Index;
using ccvt::Options;
using ccvt::Pair;
using ccvt::Random;
using ccvt::Schedule;
using ccvt::SiteNumber;
using ccvt::Tile;
using ccvt::Tiling;

namespace {

// `count` different pairs, in random order.
std::vector<Pair> random_pairs(Random& random, Index nodes, std::size_t count) {
  std::set<Pair> pairs;
  while (pairs.size() < count) {
    const auto n = static_cast<std::uint64_t>(nodes);
    const auto a = static_cast<Index>(random.below(n));
    const auto b = static_cast<Index>(random.below(n));
    if (a != b) pairs.emplace(std::min(a, b), std::max(a, b));
  }
  std::vector<Pair> result(pairs.begin(), pairs.end());
  random.shuffle(std::span(result));
  return result;
}

bool conflict(const Pair& a, const Pair& b) {
  return a.first == b.first || a.first == b.second || a.second == b.first || a.second == b.second;
}

// Program 5, cached stage, word for word; of batches of one size the oldest is taken.
Batches naive_batches(const std::vector<Pair>& pairs) {
  Batches batches;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    std::vector<std::size_t> increasing(batches.size());
    std::iota(increasing.begin(), increasing.end(), std::size_t{0});
    std::stable_sort(increasing.begin(), increasing.end(), [&](std::size_t x, std::size_t y) {
      return batches[x].size() < batches[y].size();
    });
    bool added = false;
    for (const std::size_t b : increasing) {
      const bool free = std::none_of(batches[b].begin(), batches[b].end(), [&](std::size_t other) {
        return conflict(pairs[other], pairs[p]);
      });
      if (!free) continue;
      batches[b].push_back(p);
      added = true;
      break;
    }
    if (!added) batches.push_back({p});
  }
  return batches;
}

std::size_t most_conflicts(const std::vector<Pair>& pairs) {
  std::size_t most = 0;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    std::size_t count = 0;
    for (std::size_t q = 0; q < pairs.size(); ++q) {
      count += p != q && conflict(pairs[p], pairs[q]) ? 1 : 0;
    }
    most = std::max(most, count);
  }
  return most;
}

}  // namespace

TEST_SUITE_BEGIN("schedule");

TEST_CASE("greedy batches follow Program 5") {
  Random random(8);
  for (const auto& [nodes, count] :
       {std::pair<Index, std::size_t>{2, 1}, {5, 10}, {20, 15}, {20, 100}, {60, 200}, {12, 66}}) {
    for (int trial = 0; trial < 10; ++trial) {
      const auto pairs = random_pairs(random, nodes, count);
      const Batches batches = ccvt::greedy_batches(pairs, static_cast<std::size_t>(nodes));
      CHECK(batches == naive_batches(pairs));
      CHECK(batches.size() <= most_conflicts(pairs) + 1);
      std::vector<int> times(pairs.size(), 0);
      for (const auto& batch : batches) {
        std::set<SiteNumber> nodes_used;
        for (const std::size_t p : batch) {
          ++times[p];
          REQUIRE(nodes_used.insert(pairs[p].first).second);
          REQUIRE(nodes_used.insert(pairs[p].second).second);
        }
      }
      CHECK(std::all_of(times.begin(), times.end(), [](int t) { return t == 1; }));
    }
  }
  CHECK(ccvt::greedy_batches({}, 5).empty());
}

TEST_CASE("round robin covers each pair once, in rounds without conflict") {
  for (std::size_t nodes = 1; nodes <= 33; ++nodes) {
    std::set<Pair> seen;
    for (std::size_t round = 0; round < nodes; ++round) {
      std::set<std::size_t> used;
      ccvt::round_robin(nodes, round, [&](std::size_t a, std::size_t b) {
        REQUIRE((a < b && b < nodes));
        REQUIRE(used.insert(a).second);
        REQUIRE(used.insert(b).second);
        REQUIRE(seen.emplace(a, b).second);
      });
      CHECK(used.size() + 2 >= nodes);  // nearly all take part
    }
    CHECK(seen.size() == nodes * (nodes - 1) / 2);
  }
}

TEST_CASE("a schedule of tiles covers each pair once; tasks of a batch share no site") {
  Random random(9);
  for (const Index tile : {1, 2, 7, 64, 1000}) {
    for (const Index sites : {2, 13, 64, 200}) {
      const auto possible = static_cast<std::size_t>(sites * (sites - 1) / 2);
      for (const std::size_t count : {std::size_t{1}, std::min<std::size_t>(possible, 600)}) {
        auto pairs = random_pairs(random, sites, count);
        const Tiling tiling(sites, tile);
        const Schedule schedule = ccvt::schedule_pairs(pairs, tiling);
        std::vector<Pair> scheduled;
        std::size_t tasks_seen = 0;
        for (std::size_t b = 0; b < schedule.batch_count(); ++b) {
          std::set<SiteNumber> taken;
          REQUIRE_FALSE(schedule.batch(b).empty());
          std::size_t longest = pairs.size();
          for (const auto& task : schedule.batch(b)) {
            ++tasks_seen;
            REQUIRE(task.size() > 0);
            REQUIRE(task.size() <= longest);
            longest = task.size();
            if (tile == 1) REQUIRE(task.size() == 1);
            std::set<SiteNumber> own;
            schedule.for_pairs(task, [&](SiteNumber i, SiteNumber j) {
              scheduled.emplace_back(i, j);
              own.insert({i, j});
              const std::set<Tile> of_pair{tiling.tile_of(i), tiling.tile_of(j)};
              REQUIRE(of_pair == std::set<Tile>{task.a, task.b});
            });
            for (const SiteNumber site : own) REQUIRE(taken.insert(site).second);
          }
        }
        REQUIRE(tasks_seen == schedule.tasks.size());
        std::vector<Pair> in_order = scheduled;
        std::sort(in_order.begin(), in_order.end());
        std::sort(pairs.begin(), pairs.end());
        CHECK(in_order == pairs);
        if (tile == 1) continue;
        // Whatever their order was.
        const Schedule same = ccvt::schedule_pairs(pairs, tiling, ccvt::Arena(2));
        std::vector<Pair> again;
        same.run(ccvt::Arena(1), tiling, [&](const Schedule::Task& task, int) {
          same.for_pairs(task, [&](SiteNumber i, SiteNumber j) { again.emplace_back(i, j); });
        });
        CHECK(again == scheduled);
      }
    }
  }
  CHECK(ccvt::schedule_pairs({}, {5, 1}).batch_count() == 0);
  CHECK(ccvt::schedule_pairs({}, {5, 64}).batch_count() == 0);
}

TEST_CASE("with tiles of one site the schedule is the paper's") {
  Random random(10);
  const auto pairs = random_pairs(random, 50, 180);
  const Schedule schedule = ccvt::schedule_pairs(pairs, {50, 1});
  const Batches batches = naive_batches(pairs);
  REQUIRE(schedule.batch_count() == batches.size());
  for (std::size_t b = 0; b < batches.size(); ++b) {
    std::vector<Pair> expected;
    for (const std::size_t p : batches[b]) expected.push_back(pairs[p]);
    std::vector<Pair> scheduled;
    for (const auto& task : schedule.batch(b)) scheduled.push_back(schedule.pairs[task.begin]);
    CHECK(scheduled == expected);
  }
}

/// With their points, on a line in their order.
std::vector<ccvt::Level> levels_of(const std::vector<Index>& capacities, const Options& options) {
  std::vector<ccvt::Level> levels = ccvt::make_levels(capacities, options);
  if (levels.size() == 1) return levels;
  const Index count = ccvt::test::sum_of(capacities);
  const Eigen::RowVectorXd line = Eigen::RowVectorXd::LinSpaced(count, 0, 1);
  ccvt::PointsAlongCurve<double> along(ccvt::OwnPoints<double>(ccvt::view_points(line)), count,
                                       ccvt::Box::unit(1), ccvt::Arena(2));
  ccvt::share_points(levels, along, 0, options.seed, ccvt::Arena(2));
  return levels;
}

TEST_CASE("levels are nested, exact, and each point joins once") {
  const auto unequal = ccvt::test::unequal_capacities(30);
  for (const auto& capacities : {std::vector<Index>(40, 256), std::vector<Index>(3, 17), unequal,
                                 std::vector<Index>(50, 1), std::vector<Index>{100}}) {
    const Index points = ccvt::test::sum_of(capacities);
    for (const int level_points : {1, 4, 100}) {
      for (const int factor : {2, 4, 7}) {
        CAPTURE(points);
        CAPTURE(level_points);
        CAPTURE(factor);
        Options options;
        options.level_points = level_points;
        options.level_factor = factor;
        const auto levels = levels_of(capacities, options);
        CHECK(levels.back().capacities == capacities);
        std::vector<int> joins(static_cast<std::size_t>(points), 0);
        Index joined = 0;
        for (std::size_t l = 0; l < levels.size(); ++l) {
          const auto joining = levels[l].joining.all(ccvt::Arena(2));
          CHECK(std::is_sorted(joining.begin(), joining.end()));
          CHECK(joining.size() == levels[l].joining.size());
          for (const auto p : joining) ++joins[p];
          joined += static_cast<Index>(joining.size());
          // In parts, they are the same.
          std::vector<ccvt::PointNumber> in_parts;
          levels[l].joining.for_parts(1, ccvt::Arena(3),
                                      [&](std::span<const ccvt::PointNumber> part) {
                                        in_parts.insert(in_parts.end(), part.begin(), part.end());
                                      });
          CHECK(std::equal(in_parts.begin(), in_parts.end(), joining.begin(), joining.end()));
          CHECK(joined == ccvt::test::sum_of(levels[l].capacities));
          // A coarse level is worth having: `level_points` a site or more, and fewer than the next.
          if (levels.size() > 1) {
            CHECK(joined >= level_points * static_cast<Index>(capacities.size()));
          }
          for (std::size_t s = 0; l > 0 && s < capacities.size(); ++s) {
            CHECK(levels[l - 1].capacities[s] >= 1);
            CHECK(levels[l - 1].capacities[s] <= levels[l].capacities[s]);
          }
          if (l > 0) CHECK(levels[l - 1].joining.size() < static_cast<std::size_t>(joined));
        }
        CHECK(std::all_of(joins.begin(), joins.end(), [](int j) { return j == 1; }));
      }
    }
  }
}

TEST_CASE("the points of a level come in parts of so many, the same for any threads") {
  const std::vector<Index> capacities(1200, 256);  // five blocks of points
  const Index points = ccvt::test::sum_of(capacities);
  const auto levels = levels_of(capacities, Options());
  REQUIRE(levels.size() > 1);
  std::vector<int> joins(static_cast<std::size_t>(points), 0);
  for (const auto& level : levels) {
    const auto joining = level.joining.all();
    CHECK(joining.size() == level.joining.size());
    for (const auto p : joining) ++joins[p];
    for (const int threads : {1, 2, 3}) {
      for (const std::size_t most : {std::size_t{1}, std::size_t{100000}, joining.size()}) {
        std::vector<ccvt::PointNumber> in_parts;
        level.joining.for_parts(most, ccvt::Arena(threads), [&](const auto& part) {
          CHECK(part.size() <= std::max(most, std::size_t{1} << 16));
          in_parts.insert(in_parts.end(), part.begin(), part.end());
        });
        CHECK(std::equal(in_parts.begin(), in_parts.end(), joining.begin(), joining.end()));
      }
    }
  }
  CHECK(std::all_of(joins.begin(), joins.end(), [](int j) { return j == 1; }));
}

TEST_CASE("without multilevel, or with small capacities, there is one level") {
  const std::vector<Index> capacities(10, 100);
  Options options;
  CHECK(levels_of(capacities, options).size() == 2);  // 25, 100 points a site
  options.multilevel = false;
  CHECK(levels_of(capacities, options).size() == 1);
  CHECK(levels_of(std::vector<Index>(10, 15), {}).size() == 1);
}

TEST_CASE("every point is as likely as any to be on the coarsest level") {
  const std::vector<Index> capacities(4, 32);
  std::vector<int> chosen(128, 0);
  constexpr int trials = 4000;
  for (int t = 0; t < trials; ++t) {
    Options options;
    options.seed = static_cast<std::uint64_t>(t);
    const auto levels = levels_of(capacities, options);
    REQUIRE(levels.size() == 2);
    for (const auto p : levels[0].joining.all()) ++chosen[p];
  }
  // A quarter of the points: mean 1000, standard deviation 27.
  for (const int count : chosen) CHECK(std::abs(count - trials / 4) < 5 * 27);
}

TEST_CASE("rounds hold every pair once, and no site twice") {
  Random random(9);
  for (const Index sites : {2, 3, 10, 61}) {
    const auto most = static_cast<std::size_t>(sites) * static_cast<std::size_t>(sites - 1) / 2;
    for (const std::size_t count : {std::size_t{0}, std::size_t{1}, most / 2, most}) {
      auto pairs = random_pairs(random, sites, count);
      const Schedule schedule = ccvt::schedule_rounds(pairs, static_cast<std::size_t>(sites));
      CHECK(schedule.batch_count() <= static_cast<std::size_t>(sites));
      std::size_t tasks = 0;
      for (std::size_t b = 0; b < schedule.batch_count(); ++b) {
        std::set<SiteNumber> seen;
        REQUIRE(!schedule.batch(b).empty());
        for (const auto& task : schedule.batch(b)) {
          REQUIRE(task.end == task.begin + 1);
          const Pair& pair = schedule.pairs[task.begin];
          CHECK(seen.insert(pair.first).second);
          CHECK(seen.insert(pair.second).second);
          ++tasks;
        }
      }
      CHECK(tasks == pairs.size());
      std::vector<Pair> scheduled(schedule.pairs.begin(), schedule.pairs.end());
      std::sort(scheduled.begin(), scheduled.end());
      std::sort(pairs.begin(), pairs.end());
      CHECK(scheduled == pairs);
    }
  }
}

TEST_SUITE_END();
