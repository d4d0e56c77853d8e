#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <thread>
#include <vector>

#include "schedule/schedule.h"

namespace ccvt {

/// Runs the tasks of a schedule by several workers, of each tile in the order of the batches, as if
/// one batch ended before the next one began. But nobody waits for the end of a batch: workers take
/// the tasks in their order, and wait for those that have a tile of theirs and were taken before.
/// The first task that has not ended never waits, so all of them end.
class InOrder {
 public:
  using Task = Schedule::Task;

  /// load(task): 0 where it has nothing to do, and is left out. O(tasks + tiles).
  template <class Load>
  InOrder(const Schedule& schedule, const Tiling& tiling, const Load& load)
      : ended_(tiling.count()) {
    std::vector<std::uint32_t> tasks_of(tiling.count(), 0);
    for (std::size_t b = 0; b < schedule.batch_count(); ++b) {
      std::size_t pairs = 0;  // of the last run
      for (const Task& task : schedule.batch(b)) {
        if (load(task) == 0) continue;
        turns_.push_back({&task, tasks_of[task.a], tasks_of[task.b]});
        ++tasks_of[task.a];
        if (task.a != task.b) ++tasks_of[task.b];
        pairs += task.size();
        if (pairs < tiling.pairs_per_grain()) continue;
        run_end_.push_back(turns_.size());
        pairs = 0;
      }
      if (pairs > 0) run_end_.push_back(turns_.size());
    }
  }

  /// Calls body(task, worker). Once.
  template <class Body>
  void run(const Arena& arena, const Body& body) {
    const auto workers = static_cast<std::size_t>(arena.threads());
    arena.for_ranges(std::min(workers, run_end_.size()), 1,
                     [&](std::size_t, std::size_t, int worker) {
                       try {
                         work(arena, body, worker);
                       } catch (...) {
                         failed_ = true;
                         throw;
                       }
                     });
  }

 private:
  struct Turn {
    const Task* task;
    std::uint32_t before_a;  ///< so many tasks of its tile have their turns before
    std::uint32_t before_b;
  };

  /// Takes runs of tasks until there are no more. Within a run, too, tasks are in order.
  template <class Body>
  void work(const Arena& arena, const Body& body, int worker) {
    for (std::size_t r = next_++; r < run_end_.size(); r = next_++) {
      for (std::size_t t = r > 0 ? run_end_[r - 1] : 0; t < run_end_[r]; ++t) {
        const Turn& turn = turns_[t];
        if (failed_.load(std::memory_order_relaxed)) return;
        if (!is_due(turn) && !wait(arena, turn)) return;
        arena.check();
        const Task& task = *turn.task;
        body(task, worker);
        ended_[task.a].store(turn.before_a + 1, std::memory_order_release);
        if (task.a != task.b) ended_[task.b].store(turn.before_b + 1, std::memory_order_release);
      }
    }
  }

  [[nodiscard]] bool is_due(const Turn& turn) const {
    return ended_[turn.task->a].load(std::memory_order_acquire) == turn.before_a &&
           ended_[turn.task->b].load(std::memory_order_acquire) == turn.before_b;
  }
  /// So many tasks of one of its tiles have not ended yet, and are other workers'.
  [[nodiscard]] std::uint32_t ahead(const Turn& turn) const {
    return std::max(turn.before_a - ended_[turn.task->a].load(std::memory_order_relaxed),
                    turn.before_b - ended_[turn.task->b].load(std::memory_order_relaxed));
  }
  /// False where another worker has failed. Who is among the next looks on, for to be woken takes
  /// as long as several tasks; the others leave their processors.
  bool wait(const Arena& arena, const Turn& turn) const {
    constexpr int kLooks = 200;  // about a microsecond
    constexpr std::uint32_t kNext = 8;
    constexpr std::chrono::microseconds kSleep{50};
    const Arena::Waiting waiting(arena);
    for (int looks = 1; !is_due(turn); ++looks) {
      if (failed_.load(std::memory_order_relaxed)) return false;
      if (looks % kLooks != 0) continue;
      if (ahead(turn) > kNext) {
        std::this_thread::sleep_for(kSleep);
      } else {
        std::this_thread::yield();
      }
    }
    return true;
  }

  std::vector<Turn> turns_;
  std::vector<std::size_t> run_end_;  ///< tasks that a worker takes at once, in one batch
  std::vector<std::atomic<std::uint32_t>> ended_;  ///< of each tile, tasks
  alignas(64) std::atomic<std::size_t> next_{0};   ///< run to be taken
  std::atomic<bool> failed_{false};
};

}  // namespace ccvt
