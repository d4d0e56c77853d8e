#include "schedule/schedule.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>

#include "parallel/loops.h"

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
  const auto lower_tile = [&](const Pair& p) {
    return tiling.tile_of(std::min(p.first, p.second));
  };
  const auto upper_tile = [&](const Pair& p) {
    return tiling.tile_of(std::max(p.first, p.second));
  };
  auto by_tile = group_by_key<Pair>(
      arena, pairs.size(), tiling.count(), [&](std::size_t k) { return pairs[k]; },
      [&](const Pair& p) { return lower_tile(p); });
  const Buffer<Task> tasks =
      collect<Task>(arena, tiling.count(), 4,
                    [&](std::size_t begin, std::size_t end, std::vector<Task>& out, int) {
                      for (std::size_t t = begin; t < end; ++t) {
                        const auto here = by_tile[t];
                        std::sort(here.begin(), here.end(), [&](const Pair& x, const Pair& y) {
                          const Tile to_x = upper_tile(x);
                          const Tile to_y = upper_tile(y);
                          return to_x != to_y ? to_x < to_y : x < y;
                        });
                        const Tile own(t);
                        for (std::size_t k = 0; k < here.size(); ++k) {
                          const std::size_t place = by_tile.first[t] + k;
                          if (k == 0 || upper_tile(here[k]) != out.back().b) {
                            out.push_back({own, upper_tile(here[k]), place, place});
                          }
                          out.back().end = place + 1;
                        }
                      }
                    });
  schedule.pairs = std::move(by_tile.items);
  put_in_batches({tasks.begin(), tasks.end()}, tiling.count(), arena, schedule);
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
