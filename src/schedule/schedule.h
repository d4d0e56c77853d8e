#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"
#include "parallel/buffer.h"
#include "schedule/pair.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Batches of pairs, by their numbers: within a batch no two pairs share a site, so its pairs can
/// run at the same time. Every pair is in exactly one batch.
using Batches = std::vector<std::vector<std::size_t>>;

/// Distributes pairs over batches: each pair, in the order given, joins the smallest batch it does
/// not conflict with, or else starts a new one [4.3, Program 5, cached stage]. Of batches of one
/// size the oldest is taken. At most d + 1 batches, where d is the largest number of conflicts of
/// one pair. O(pairs * batches). A pair of a site with itself conflicts with every pair of that
/// site.
Batches greedy_batches(std::span<const Pair> pairs, std::size_t sites);

/// Calls visit(a, b), a < b, for the pairs of round `round` of a round-robin tournament of `nodes`
/// nodes: all pairs whose sum is `round` modulo `nodes` [4.3, Program 5, full stage]. No two share
/// a node; rounds 0..nodes-1 cover each pair once.
template <class Visit>
void round_robin(std::size_t nodes, std::size_t round, Visit visit) {
  for (std::size_t a = 0, b = round; a < b; ++a, --b) visit(a, b);
  for (std::size_t a = round + 1, b = nodes - 1; a < b; ++a, --b) visit(a, b);
}

/// A pass over pairs of sites: batches of tasks, each a run of pairs between the same two tiles, or
/// inside one. Tasks of one batch share no site; the pairs of one task run in order. Depends on the
/// pairs and tiles alone, not on threads. Where several ranks have the tiles, each may have the
/// pairs of its own tiles' tasks only: see schedule_own_pairs().
struct Schedule {
  struct Task {
    Tile a;
    Tile b;
    std::size_t begin;  ///< of its pairs; where these are not here, end - begin says how many
    std::size_t end;
    [[nodiscard]] std::size_t size() const { return end - begin; }
  };
  Buffer<Pair> pairs;                       ///< grouped by task
  std::vector<Task> tasks;                  ///< grouped by batch; in it, the longest first
  std::vector<std::size_t> batch_begin{0};  ///< of batches, in tasks; one more than batches

  [[nodiscard]] std::size_t batch_count() const { return batch_begin.size() - 1; }
  [[nodiscard]] std::span<const Task> batch(std::size_t b) const {
    return std::span(tasks).subspan(batch_begin[b], batch_begin[b + 1] - batch_begin[b]);
  }
  [[nodiscard]] std::span<Task> batch(std::size_t b) {
    return std::span(tasks).subspan(batch_begin[b], batch_begin[b + 1] - batch_begin[b]);
  }

  [[nodiscard]] std::span<const Pair> pairs_of(const Task& task) const {
    return pairs.span().subspan(task.begin, task.size());
  }
  template <class Visit>
  void for_pairs(const Task& task, const Visit& visit) const {
    for (const auto& [i, j] : pairs_of(task)) visit(i, j);
  }

  /// Calls body(task, worker) for each task, one batch after the other.
  template <class Body>
  void run(const Arena& arena, const Tiling& tiling, const Body& body) const {
    for (std::size_t b = 0; b < batch_count(); ++b) run_batch(arena, tiling, batch(b), body);
  }
  template <class Body>
  static void run_batch(const Arena& arena, const Tiling& tiling, std::span<const Task> tasks,
                        const Body& body);
};

/// The pairs of two tiles, or inside one, become a task; pairs of tiles are distributed by
/// greedy_batches(). With tiles of one site every pair is a task, in the order given, which is the
/// paper's schedule; else the order of `pairs`, which are different, does not matter.
Schedule schedule_pairs(std::span<const Pair> pairs, const Tiling& tiling,
                        const Arena& arena = Arena(1));

/// schedule_pairs() of the lists of all ranks (see own_pairs.h), of which each gives its own, in
/// order. It has the pairs of tasks with a tile of its own; of others only how many these are. All
/// ranks.
Schedule schedule_own_pairs(std::span<const Pair> own, const Tiling& tiling, const Arena& arena);

/// One batch for each round of round_robin() in which there are pairs, every pair a task: at most
/// `sites` batches. O(pairs + sites).
Schedule schedule_rounds(std::span<const Pair> pairs, std::size_t sites,
                         const Arena& arena = Arena(1));

template <class Body>
void Schedule::run_batch(const Arena& arena, const Tiling& tiling, std::span<const Task> tasks,
                         const Body& body) {
  std::size_t pairs = 1;
  for (const Task& task : tasks) pairs += task.size();
  const std::size_t grain = 1 + tiling.pairs_per_grain() * tasks.size() / (pairs + 1);
  arena.for_ranges(tasks.size(), grain, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t t = begin; t < end; ++t) body(tasks[t], worker);
  });
}

}  // namespace ccvt
