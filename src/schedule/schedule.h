#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {

using Pair = std::pair<Index, Index>;

/// Sorts pairs of nodes, by their first and then by their second. O(pairs + nodes).
void sort_pairs(std::vector<Pair>& pairs, Index nodes);

/// Batches of pairs of nodes: within a batch no two pairs share a node, so its pairs can run at
/// the same time. Every pair is in exactly one batch.
using Batches = std::vector<std::vector<Index>>;

/// Distributes pairs over batches: each pair, in the order given, joins the smallest batch it does
/// not conflict with, or else starts a new one [4.3, Program 5, cached stage]. Of batches of one
/// size the oldest is taken. At most d + 1 batches, where d is the largest number of conflicts of
/// one pair. The result numbers the pairs. O(pairs * batches).
/// A pair of a node with itself conflicts with every pair of that node.
Batches greedy_batches(std::span<const Pair> pairs, Index nodes);

/// Calls visit(a, b), a < b, for the pairs of round `round` of a round-robin tournament of `nodes`
/// nodes: all pairs whose sum is `round` modulo `nodes` [4.3, Program 5, full stage]. No two share
/// a node; rounds 0..nodes-1 cover each pair once.
template <class Visit>
void round_robin(Index nodes, Index round, Visit visit) {
  for (Index a = 0, b = round; a < b; ++a, --b) visit(a, b);
  for (Index a = round + 1, b = nodes - 1; a < b; ++a, --b) visit(a, b);
}

/// A pass over pairs of sites: batches of tasks, each a run of pairs. Tasks of one batch share no
/// site; the pairs of one task run in order. Depends on the pairs and tiles alone, not on threads.
struct Schedule {
  struct Task {
    std::int64_t begin;
    std::int64_t end;
  };
  std::vector<Pair> pairs;                   ///< grouped by task
  std::vector<Task> tasks;                   ///< grouped by batch
  std::vector<std::int64_t> batch_begin{0};  ///< of batches, in tasks; one more than batches

  [[nodiscard]] std::size_t batch_count() const { return batch_begin.size() - 1; }
  [[nodiscard]] std::span<const Task> batch(std::size_t b) const {
    return std::span(tasks).subspan(static_cast<std::size_t>(batch_begin[b]),
                                    static_cast<std::size_t>(batch_begin[b + 1] - batch_begin[b]));
  }
};

/// Groups sites into tiles of `tile_sites` consecutive numbers; the pairs of two tiles, or inside
/// one, become a task; pairs of tiles are distributed by greedy_batches(). With tiles of one site
/// every pair is a task, which is the paper's schedule.
Schedule schedule_pairs(std::span<const Pair> pairs, Index sites, Index tile_sites);

/// One batch for each round of round_robin() in which there are pairs, every pair a task: at most
/// `sites` batches. O(pairs + sites).
Schedule schedule_rounds(std::span<const Pair> pairs, Index sites);

}  // namespace ccvt
