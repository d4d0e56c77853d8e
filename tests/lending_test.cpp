#include "schedule/lending.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <span>
#include <thread>
#include <utility>
#include <vector>

#include "ccvt/ranks.h"
#include "schedule/schedule.h"
#include "schedule/tiling.h"
#include "support/thread_ranks.h"
#include "support/wait_for.h"

namespace {

using ccvt::Index;
using ccvt::Schedule;
using ccvt::SiteNumber;
using ccvt::Tile;
using ccvt::Tiling;

/// Batches of tasks, each with its number in the place of its first pair.
struct Batches {
  std::vector<std::vector<Schedule::Task>> all;
  [[nodiscard]] std::size_t batch_count() const { return all.size(); }
  [[nodiscard]] std::span<const Schedule::Task> batch(std::size_t b) const { return all[b]; }
};

/// Of random pairs of tiles, at most one a tile in each batch.
Batches random_batches(std::size_t tiles, std::size_t count, std::mt19937& random) {
  Batches batches;
  std::size_t number = 0;
  for (std::size_t b = 0; b < count; ++b) {
    std::vector<std::size_t> order(tiles);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), random);
    order.resize(random() % (tiles + 1));
    std::vector<Schedule::Task>& batch = batches.all.emplace_back();
    for (std::size_t k = 0; k < order.size();) {
      const bool alone = k + 1 == order.size() || random() % 3 == 0;
      const std::size_t a = order[k];
      const std::size_t z = alone ? a : order[k + 1];
      const std::size_t size = random() % 5;
      batch.push_back({Tile(std::min(a, z)), Tile(std::max(a, z)), number, number + size});
      number += 5;
      k += alone ? 1 : 2;
    }
  }
  return batches;
}

/// What has been done to each site: the numbers of tasks.
using Logs = std::vector<std::vector<std::size_t>>;

/// Lends logs. A task without pairs has nothing to do.
struct LogLender {
  const Tiling& tiling;
  Logs& logs;
  std::map<std::pair<int, std::size_t>, std::size_t>& known;  ///< of a log, what another rank has

  [[nodiscard]] bool has_work(const Schedule::Task& task) const { return task.size() > 0; }
  [[nodiscard]] std::size_t load(const Schedule::Task& task) const { return task.size(); }
  void add_sites(const Schedule::Task&, Tile tile, std::vector<SiteNumber>& sites) const {
    for (const SiteNumber s : tiling.sites_of(tile)) sites.push_back(s);
  }
  [[nodiscard]] bool lacks(int rank, SiteNumber site) const {
    return known[{rank, site}] != logs[site].size();
  }
  void put(ccvt::ByteWriter& message, SiteNumber site, int rank) const {
    message.put(logs[site]);
    known[{rank, site}] = logs[site].size();
  }
  void take(ccvt::ByteReader& message, SiteNumber site, int rank) const {
    message.get(logs[site]);
    known[{rank, site}] = logs[site].size();
  }
};

Tiling tiling_on(ccvt::Ranks* ranks, Index sites, Index sites_per_tile) {
  Tiling tiling(sites, sites_per_tile);
  if (ranks != nullptr) {
    tiling.deal(*ranks, std::vector<Index>(static_cast<std::size_t>(sites), 1));
  }
  return tiling;
}

void log(const Tiling& tiling, const Schedule::Task& task, Logs& logs) {
  if (task.size() == 0) return;
  for (const Tile tile : {task.a, task.b}) {
    for (const SiteNumber s : tiling.sites_of(tile)) logs[s].push_back(task.begin);
  }
}

/// What a rank is that does not know what has come.
class Blind final : public ccvt::Ranks {
 public:
  explicit Blind(ccvt::Ranks& ranks) : ranks_(ranks) {}
  [[nodiscard]] int rank() const override { return ranks_.rank(); }
  [[nodiscard]] int count() const override { return ranks_.count(); }
  [[nodiscard]] std::vector<Bytes> gather(std::span<const std::byte> own) override {
    return ranks_.gather(own);
  }
  [[nodiscard]] std::vector<Bytes> exchange(std::vector<Bytes> to) override {
    return ranks_.exchange(std::move(to));
  }
  void send(int to, Bytes message) override { ranks_.send(to, std::move(message)); }
  [[nodiscard]] Bytes receive(int from) override { return ranks_.receive(from); }

 private:
  ccvt::Ranks& ranks_;
};

/// Runs batches on a rank, or alone, with so many threads; adds to logs, and counts tasks.
void run_logged(const Tiling& tiling, const Batches& batches, int threads, std::size_t most_waiting,
                Logs& logs, std::atomic<std::size_t>& done, const std::function<void()>& pause) {
  std::map<std::pair<int, std::size_t>, std::size_t> known;
  const LogLender lender{tiling, logs, known};
  const ccvt::Arena arena(threads);
  const auto work = [&](std::span<const Schedule::Task> tasks) {
    Schedule::run_batch(arena, tiling, tasks, [&](const Schedule::Task& task, int) {
      pause();
      if (task.size() > 0) ++done;
      log(tiling, task, logs);
    });
  };
  if (tiling.ranks() == nullptr) {
    for (const auto& batch : batches.all) work(batch);
    return;
  }
  ccvt::RankBatches on_rank(tiling, lender, work, threads, most_waiting);
  for (const auto& batch : batches.all) on_rank.run(batch);
  on_rank.finish();
}

TEST_SUITE("lending") {
  TEST_CASE("on several ranks the tasks of each tile run in the order of the batches") {
    constexpr Index kSites = 60;
    constexpr Index kSitesPerTile = 3;
    for (unsigned seed = 0; seed < 40; ++seed) {
      CAPTURE(seed);
      std::mt19937 random(seed);
      const Tiling alone = tiling_on(nullptr, kSites, kSitesPerTile);
      const std::vector<Batches> passes{random_batches(alone.count(), 12, random),
                                        random_batches(alone.count(), 1, random),
                                        random_batches(alone.count(), 25, random)};
      Logs expected(kSites);
      std::atomic<std::size_t> tasks = 0;
      for (const Batches& batches : passes) {
        run_logged(alone, batches, 1, 0, expected, tasks, [] {});
      }
      const int count = 2 + static_cast<int>(seed % 5);
      const bool blind = seed % 2 == 1;
      std::vector<int> wrong(static_cast<std::size_t>(count), 0);
      std::atomic<std::size_t> done = 0;
      ThreadRanks(count).run([&](ccvt::Ranks& ranks) {
        Blind unknowing(ranks);
        const Tiling tiling = tiling_on(blind ? &unknowing : &ranks, kSites, kSitesPerTile);
        std::atomic<unsigned> pauses = seed * 1000 + static_cast<unsigned>(ranks.rank());
        const auto pause = [&pauses] {
          const auto length = std::minstd_rand(++pauses)() % 2000;
          if (length < 250) std::this_thread::sleep_for(std::chrono::microseconds(length));
        };
        Logs logs(kSites);
        for (const Batches& batches : passes) {
          run_logged(tiling, batches, 1 + static_cast<int>(seed / 5 % 2), seed % 3 == 0 ? 2 : 1000,
                     logs, done, pause);
        }
        for (const SiteNumber s : tiling.own_sites()) {
          wrong[static_cast<std::size_t>(ranks.rank())] += logs[s] == expected[s] ? 0 : 1;
        }
      });
      CHECK(wrong == std::vector<int>(wrong.size(), 0));
      CHECK(done == tasks);
    }
  }

  // Rank 1 does not lend tile 3 before rank 0 has run a task of the batch after that.
  TEST_CASE("a rank that waits for another goes on with later batches") {
    const Batches batches{{{{Tile(3), Tile(3), 0, 2}},
                           {{Tile(2), Tile(3), 10, 11}, {Tile(0), Tile(0), 20, 21}},
                           {{Tile(0), Tile(1), 30, 31}, {Tile(2), Tile(2), 40, 41}}}};
    std::atomic<bool> gone_on = false;
    std::vector<std::size_t> order;
    bool waited_in_vain = false;
    ThreadRanks(2).run([&](ccvt::Ranks& ranks) {
      const Tiling tiling = tiling_on(&ranks, 6, 1);
      Logs logs(6);
      std::map<std::pair<int, std::size_t>, std::size_t> known;
      ccvt::run_batches(
          ccvt::Arena(1), tiling, batches, LogLender{tiling, logs, known},
          [&](const Schedule::Task& task, int) {
            if (task.begin == 0)
              waited_in_vain = !ccvt::test::wait_for([&] { return gone_on.load(); });
            if (task.begin == 30) gone_on = true;
            if (ranks.rank() == 0) order.push_back(task.begin);
          },
          [] { return true; });
    });
    CHECK_FALSE(waited_in_vain);
    // What borrows tile 3 is rank 0's, which has had less to do; tile 2 waits for it.
    CHECK(order == std::vector<std::size_t>{20, 30, 10, 40});
  }

  TEST_CASE("tasks of two ranks go to the one that has less to do in all batches by then") {
    ThreadRanks(2).run([&](ccvt::Ranks& ranks) {
      const Tiling tiling = tiling_on(&ranks, 4, 1);
      ccvt::Runners runners(tiling);
      const auto load = [](const Schedule::Task& task) { return task.size(); };
      const std::vector<Schedule::Task> first{{Tile(0), Tile(0), 0, 10},
                                              {Tile(1), Tile(2), 10, 13}};
      const std::vector<Schedule::Task> second{{Tile(3), Tile(3), 0, 5}, {Tile(1), Tile(2), 5, 6}};
      const std::vector<int> of_first = runners.deal(first, load);
      const std::vector<int> of_second = runners.deal(second, load);
      if (ranks.rank() != 0) return;
      CHECK(of_first == std::vector<int>{0, 1});
      CHECK(of_second == std::vector<int>{1, 1});  // 10 and 8, though 0 and 5 in this batch
    });
  }
}

}  // namespace
