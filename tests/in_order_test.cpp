// Tasks that are run in the order of their batches, by workers that do not wait for these to end.
#include "schedule/in_order.h"

#include <doctest/doctest.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <set>
#include <stdexcept>
#include <thread>
#include <vector>

#include "random.h"
#include "schedule/schedule.h"

using ccvt::Arena;
using ccvt::Index;
using ccvt::InOrder;
using ccvt::Pair;
using ccvt::Random;
using ccvt::Schedule;
using ccvt::SiteNumber;
using ccvt::Tile;
using ccvt::Tiling;

namespace {

Schedule random_schedule(Random& random, const Tiling& tiling, std::size_t count) {
  std::set<Pair> pairs;
  while (pairs.size() < count) {
    const SiteNumber i(random.below(tiling.sites()));
    const SiteNumber j(random.below(tiling.sites()));
    if (i != j) pairs.insert(Pair::ascending(i, j));
  }
  return ccvt::schedule_pairs(std::vector<Pair>(pairs.begin(), pairs.end()), tiling);
}

/// Of each tile, its tasks by their first pairs, in the order in which they are run.
class Log {
 public:
  explicit Log(const Tiling& tiling) : of_tile_(tiling.count()) {}
  void add(const Schedule::Task& task) {
    for (const Tile tile : {task.a, task.b}) of_tile_[tile].push_back(task.begin);
  }
  bool operator==(const Log&) const = default;

 private:
  std::vector<std::vector<std::size_t>> of_tile_;
};

void work_for(std::chrono::microseconds time) {
  const auto end = std::chrono::steady_clock::now() + time;
  while (std::chrono::steady_clock::now() < end) continue;
}

std::size_t all_have_work(const Schedule::Task& task) { return task.size(); }

}  // namespace

TEST_SUITE("schedule") {
  TEST_CASE("each tile's tasks run in the order of the batches, those with work, by any workers") {
    Random random(3);
    for (const Index tile : {1, 4, 16}) {
      for (const std::size_t count : {1U, 40U, 900U}) {
        const Tiling tiling(120, tile);
        const Schedule schedule = random_schedule(random, tiling, count);
        for (const std::size_t idle : {0U, 3U}) {  // one of so many
          const auto load = [&](const Schedule::Task& task) {
            return idle > 0 && task.begin % idle == 0 ? 0 : task.size();
          };
          Log batches(tiling);
          std::size_t tasks = 0;
          for (std::size_t b = 0; b < schedule.batch_count(); ++b) {
            for (const Schedule::Task& task : schedule.batch(b)) {
              if (load(task) == 0) continue;
              batches.add(task);
              ++tasks;
            }
          }
          for (const int threads : {1, 2, 4}) {
            CAPTURE(threads);
            Log log(tiling);
            std::atomic<std::size_t> run{0};
            InOrder(schedule, tiling, load)
                .run(Arena(threads), [&](const Schedule::Task& task, int) {
                  log.add(task);  // no other task has one of its tiles
                  work_for(std::chrono::microseconds(task.begin % 5 * 4));
                  ++run;
                });
            CHECK(log == batches);
            CHECK(run == tasks);
          }
        }
      }
    }
  }

  TEST_CASE("a worker goes on with later batches while another is at a long task") {
    // Batches: a long task and a short one, then one that has a tile of the short one's.
    const Tiling tiling = Tiling::of_points(6, 6 << 13, 1);  // so many that workers take one pair
    const std::vector<Pair> pairs = {Pair(SiteNumber(0), SiteNumber(1)),
                                     Pair(SiteNumber(2), SiteNumber(3)),
                                     Pair(SiteNumber(2), SiteNumber(4))};
    const Schedule schedule = ccvt::schedule_pairs(pairs, tiling);
    REQUIRE(schedule.batch_count() == 2);
    const Arena arena(2);
    if (arena.threads() < 2) return;
    std::atomic<bool> later{false};
    bool waited = false;
    InOrder(schedule, tiling, all_have_work).run(arena, [&](const Schedule::Task& task, int) {
      if (task.b == Tile(4)) later = true;
      if (task.a != Tile(0)) return;
      const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
      while (!later && std::chrono::steady_clock::now() < end) std::this_thread::yield();
      waited = later;
    });
    CHECK(waited);
  }

  TEST_CASE("an exception of a task ends the others that wait for it") {
    Random random(5);
    const Tiling tiling(40, 2);
    const Schedule schedule = random_schedule(random, tiling, 300);
    for (std::size_t bad = 0; bad < schedule.tasks.size(); bad += 7) {
      for (const int threads : {1, 2, 4}) {
        std::atomic<std::size_t> after{0};
        const auto body = [&](const Schedule::Task& task, int) {
          if (&task == &schedule.tasks[bad]) throw std::runtime_error("bad");
          if (&task > &schedule.tasks[bad]) ++after;
        };
        CHECK_THROWS_WITH_AS(InOrder(schedule, tiling, all_have_work).run(Arena(threads), body),
                             "bad", std::runtime_error);
        if (threads == 1) CHECK(after == 0);
      }
    }
  }

  TEST_CASE("after an exception of a task no worker goes on with others") {
    std::vector<Pair> pairs;  // that have no site in common
    for (Index k = 0; k < 400; ++k) pairs.emplace_back(SiteNumber(2 * k), SiteNumber(2 * k + 1));
    const Tiling tiling =
        Tiling::of_points(800, 800 << 13, 1);  // so many that workers take one pair
    const Schedule schedule = ccvt::schedule_pairs(pairs, tiling);
    REQUIRE(schedule.tasks.size() == 400);
    for (const int threads : {1, 2, 4}) {
      const Arena arena(threads);
      std::atomic<int> others{0};
      const auto body = [&](const Schedule::Task& task, int) {
        if (&task == &schedule.tasks[0]) {
          const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
          while (arena.threads() > 1 && others == 0 && std::chrono::steady_clock::now() < end) {
            std::this_thread::yield();
          }
          throw std::runtime_error("bad");
        }
        ++others;
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      };
      CHECK_THROWS_WITH_AS(InOrder(schedule, tiling, all_have_work).run(Arena(threads), body),
                           "bad", std::runtime_error);
      CHECK(others < 200);
    }
  }

  TEST_CASE("many workers that wait for one tile take their turns") {
    std::vector<Pair> pairs;
    for (Index k = 1; k < 200; ++k) pairs.emplace_back(SiteNumber(0), SiteNumber(k));
    const Tiling tiling = Tiling::of_points(200, 200 << 13, 1);
    const Schedule schedule = ccvt::schedule_pairs(pairs, tiling);
    for (const int threads : {2, 16, 64}) {
      std::vector<const Schedule::Task*> log;  // not guarded: one at a time
      InOrder(schedule, tiling, all_have_work)
          .run(Arena(threads), [&](const Schedule::Task& task, int) { log.push_back(&task); });
      REQUIRE(log.size() == schedule.tasks.size());
      for (std::size_t t = 0; t < log.size(); ++t) CHECK(log[t] == &schedule.tasks[t]);
    }
  }
}
