#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <span>
#include <vector>

#include "parallel/bytes.h"
#include "schedule/schedule.h"

namespace ccvt {

/// Runs a batch of tasks, each on one of the ranks that have its tiles. What the task needs of a
/// tile of another rank's is lent to the one that runs it, and comes back changed; messages are on
/// their way while tasks of a rank's own tiles run.
///
///     lender.sites(task, tile): the sites of one of its tiles that the task needs
///     lender.put(writer, site), lender.take(reader, site): what there is of a site
template <class Lender, class Body>
void run_on_ranks(const Arena& arena, const Tiling& tiling, std::span<const Schedule::Task> tasks,
                  Lender&& lender, const Body& body) {
  using Task = Schedule::Task;
  // Both ranks of a task know this; neither tile is used by another task.
  const auto runner = [&](const Task& task) {
    const bool second = (task.a.index() + task.b.index()) % 2 != 0;
    return tiling.rank_of(second ? task.b : task.a);
  };
  Ranks& ranks = *tiling.ranks();
  std::vector<Task> own;
  std::vector<Task> with_others;
  std::map<int, std::vector<const Task*>> lent;      // by the rank that runs them
  std::map<int, std::vector<const Task*>> borrowed;  // by the rank whose tiles they need
  for (const Task& task : tasks) {
    const bool has_a = tiling.is_own(task.a);
    const bool has_b = tiling.is_own(task.b);
    if (has_a && has_b) {
      own.push_back(task);
    } else if (has_a || has_b) {
      const int other = tiling.rank_of(has_a ? task.b : task.a);
      if (runner(task) == ranks.rank()) {
        with_others.push_back(task);
        borrowed[other].push_back(&task);
      } else {
        lent[other].push_back(&task);
      }
    }
  }
  const auto send = [&](const auto& by_rank, bool back) {
    for (const auto& [rank, theirs] : by_rank) {
      ByteWriter message;
      for (const Task* task : theirs) {
        const std::vector<SiteNumber> sites =
            lender.sites(*task, tiling.is_own(task->a) != back ? task->a : task->b);
        message.put(sites);
        for (const SiteNumber site : sites) lender.put(message, site);
      }
      ranks.send(rank, std::move(message.bytes));
    }
  };
  const auto receive = [&](const auto& by_rank) {
    for (const auto& [rank, theirs] : by_rank) {
      const Ranks::Bytes bytes = ranks.receive(rank);
      ByteReader message(bytes);
      std::vector<SiteNumber> sites;
      while (!message.done()) {
        message.get(sites);
        for (const SiteNumber site : sites) lender.take(message, site);
      }
    }
  };
  send(lent, false);
  Schedule::run_batch(arena, tiling, std::span<const Task>(own), body);
  receive(borrowed);
  Schedule::run_batch(arena, tiling, std::span<const Task>(with_others), body);
  send(borrowed, true);
  receive(lent);
}

}  // namespace ccvt
