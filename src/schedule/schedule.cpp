#include "schedule/schedule.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <utility>

#include "parallel/loops.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

using Task = Schedule::Task;

/// Which batches each node has a pair in: 64 batches a row.
class UsedBatches {
 public:
  explicit UsedBatches(std::size_t nodes) : nodes_(nodes) {}

  /// The smallest batch without a pair of either node; a new one when there is none.
  std::size_t add(std::size_t a, std::size_t b) {
    std::size_t smallest = sizes_.size();
    std::size_t least = std::numeric_limits<std::size_t>::max();
    for (std::size_t row = 0; row < rows_.size(); ++row) {
      std::uint64_t free = ~(rows_[row][a] | rows_[row][b]);
      for (; free != 0; free &= free - 1) {
        const std::size_t batch = 64 * row + static_cast<std::size_t>(std::countr_zero(free));
        if (batch >= sizes_.size()) break;
        if (sizes_[batch] >= least) continue;
        smallest = batch;
        least = sizes_[batch];
      }
    }
    if (smallest == sizes_.size()) {
      if (smallest % 64 == 0) rows_.emplace_back(nodes_, std::uint64_t{0});
      sizes_.push_back(0);
    }
    ++sizes_[smallest];
    const std::uint64_t bit = std::uint64_t{1} << (smallest % 64);
    rows_[smallest / 64][a] |= bit;
    rows_[smallest / 64][b] |= bit;
    return smallest;
  }

  [[nodiscard]] std::size_t batches() const { return sizes_.size(); }

 private:
  std::size_t nodes_;
  std::vector<std::vector<std::uint64_t>> rows_;
  std::vector<std::size_t> sizes_;
};

/// Each pair as a task, of tiles of one site.
std::vector<Task> tasks_of_one(std::span<const Pair> pairs) {
  std::vector<Task> tasks;
  tasks.reserve(pairs.size());
  for (const auto& [a, b] : pairs) {
    tasks.push_back({Tile(a.index()), Tile(b.index()), tasks.size(), tasks.size() + 1});
  }
  return tasks;
}

/// Puts the pairs of a tile with itself and with higher ones in the order of these: a counting
/// sort.
class TasksOfTile {
 public:
  explicit TasksOfTile(const Tiling& tiling) : tiling_(&tiling), next_(tiling.count(), 0) {}

  /// Pairs with the same other tile become a task, and are in order. `place`: of the first of
  /// these pairs in the schedule.
  void add(Tile tile, std::span<Pair> pairs, std::size_t place, std::vector<Task>& tasks) {
    others_.clear();
    for (const Pair& pair : pairs) {
      const Tile other = upper_tile(pair);
      if (next_[other]++ == 0) others_.push_back(other);
    }
    std::sort(others_.begin(), others_.end());
    std::size_t begin = 0;
    for (const Tile other : others_) begin += std::exchange(next_[other], begin);
    sorted_.resize(pairs.size());
    for (const Pair& pair : pairs) sorted_[next_[upper_tile(pair)]++] = pair;
    begin = 0;
    for (const Tile other : others_) {
      const std::size_t end = std::exchange(next_[other], 0);
      const std::span<Pair> own = std::span(sorted_).subspan(begin, end - begin);
      if (!std::is_sorted(own.begin(), own.end())) std::sort(own.begin(), own.end());
      tasks.push_back({tile, other, place + begin, place + end});
      begin = end;
    }
    std::copy(sorted_.begin(), sorted_.end(), pairs.begin());
  }

 private:
  [[nodiscard]] Tile upper_tile(const Pair& pair) const {
    return tiling_->tile_of(std::max(pair.first, pair.second));
  }

  const Tiling* tiling_;
  std::vector<std::size_t> next_;  ///< by tile, 0 but of others_: how many pairs, then where
  std::vector<Tile> others_;
  std::vector<Pair> sorted_;
};

/// The tasks of tiles that are more than single sites, by their tiles; their pairs go into the
/// schedule.
Buffer<Task> tasks_of_tiles(std::span<const Pair> pairs, const Tiling& tiling, const Arena& arena,
                            Schedule& schedule) {
  auto by_tile = group_by_key<Pair>(
      arena, pairs.size(), tiling.count(), [&](std::size_t k) { return pairs[k]; },
      [&](const Pair& p) { return tiling.tile_of(std::min(p.first, p.second)); });
  PerWorker<TasksOfTile> of_tile(arena, TasksOfTile(tiling));
  Buffer<Task> tasks =
      collect<Task>(arena, tiling.count(), 4,
                    [&](std::size_t begin, std::size_t end, std::vector<Task>& out, int worker) {
                      for (std::size_t t = begin; t < end; ++t) {
                        of_tile[worker].add(Tile(t), by_tile[t], by_tile.first[t], out);
                      }
                    });
  schedule.pairs = std::move(by_tile.items);
  return tasks;
}

/// Of all ranks, of which each tells those whose lower tile is its own. By their tiles, as those
/// are that have their pairs `here`.
std::vector<Task> tasks_of_all(std::span<const Task> here, const Tiling& tiling) {
  std::vector<Task> all;
  for (const Task& task : here) {
    if (tiling.is_own(task.a)) all.push_back({task.a, task.b, 0, task.size()});
  }
  all = joined(tiling.ranks(), std::move(all));
  auto next = here.begin();
  for (Task& task : all) {
    if (next == here.end() || next->a != task.a || next->b != task.b) continue;
    if (next->size() != task.size()) break;
    task = *next++;
  }
  if (next != here.end()) throw std::logic_error("schedule: ranks have other pairs of two tiles");
  return all;
}

/// Orders the tasks by batch.
void put_in_batches(std::vector<Task> tasks, std::size_t tiles, const Arena& arena,
                    Schedule& schedule) {
  UsedBatches used(tiles);
  std::vector<std::size_t> batch_of;
  batch_of.reserve(tasks.size());
  for (const Task& task : tasks) batch_of.push_back(used.add(task.a, task.b));
  schedule.batch_begin.assign(used.batches() + 1, 0);
  for (const std::size_t batch : batch_of) ++schedule.batch_begin[batch + 1];
  for (std::size_t b = 0; b < used.batches(); ++b) {
    schedule.batch_begin[b + 1] += schedule.batch_begin[b];
  }
  std::vector<std::size_t> next(schedule.batch_begin);
  schedule.tasks.resize(tasks.size());
  for (std::size_t t = 0; t < tasks.size(); ++t) schedule.tasks[next[batch_of[t]]++] = tasks[t];
  // So that no worker begins a long task when the others have nothing left to do.
  arena.for_each(used.batches(), 1, [&](std::size_t b) {
    const std::span<Task> own = schedule.batch(b);
    std::stable_sort(own.begin(), own.end(),
                     [](const Task& x, const Task& y) { return x.size() > y.size(); });
  });
}

}  // namespace

Batches greedy_batches(std::span<const Pair> pairs, std::size_t sites) {
  UsedBatches used(sites);
  Batches batches;
  for (std::size_t p = 0; p < pairs.size(); ++p) {
    const std::size_t batch = used.add(pairs[p].first, pairs[p].second);
    if (batch == batches.size()) batches.emplace_back();
    batches[batch].push_back(p);
  }
  return batches;
}

Schedule schedule_pairs(std::span<const Pair> pairs, const Tiling& tiling, const Arena& arena) {
  Schedule schedule;
  if (tiling.sites_per_tile() == 1) {
    schedule.pairs.reset(pairs.size());
    std::copy(pairs.begin(), pairs.end(), schedule.pairs.begin());
    put_in_batches(tasks_of_one(schedule.pairs.span()), tiling.count(), arena, schedule);
    return schedule;
  }
  const Buffer<Task> tasks = tasks_of_tiles(pairs, tiling, arena, schedule);
  put_in_batches({tasks.begin(), tasks.end()}, tiling.count(), arena, schedule);
  return schedule;
}

Schedule schedule_own_pairs(std::span<const Pair> own, const Tiling& tiling, const Arena& arena) {
  if (tiling.ranks() == nullptr) return schedule_pairs(own, tiling, arena);
  Schedule schedule;
  const Buffer<Task> here = tasks_of_tiles(own, tiling, arena, schedule);
  put_in_batches(tasks_of_all(here.span(), tiling), tiling.count(), arena, schedule);
  return schedule;
}

Schedule schedule_rounds(std::span<const Pair> pairs, std::size_t sites, const Arena& arena) {
  auto by_round = group_by_key<Pair>(
      arena, pairs.size(), sites, [&](std::size_t k) { return pairs[k]; },
      [&](const Pair& pair) { return (pair.first + pair.second) % sites; });
  Schedule schedule;
  for (std::size_t round = 0; round < by_round.count(); ++round) {
    const std::size_t end = by_round.first[round + 1];
    if (end > by_round.first[round]) schedule.batch_begin.push_back(end);
  }
  schedule.pairs = std::move(by_round.items);
  schedule.tasks = tasks_of_one(schedule.pairs.span());
  return schedule;
}

}  // namespace ccvt
