#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <span>
#include <vector>

#include "parallel/bytes.h"
#include "schedule/schedule.h"

namespace ccvt {

/// The ranks that run the tasks of a batch, each one of those that have its tiles: the one that has
/// less to do by then. `load(task)`: how long it takes. The same on all ranks.
template <class Load>
std::vector<int> runners(const Tiling& tiling, std::span<const Schedule::Task> tasks,
                         const Load& load) {
  std::vector<std::size_t> loads(static_cast<std::size_t>(tiling.ranks()->count()), 0);
  std::vector<int> runner;
  runner.reserve(tasks.size());
  const auto at = [&](int rank) -> std::size_t& { return loads[static_cast<std::size_t>(rank)]; };
  for (const Schedule::Task& task : tasks) {
    const int a = tiling.rank_of(task.a);
    runner.push_back(a == tiling.rank_of(task.b) ? a : -1);
    if (runner.back() >= 0) at(a) += load(task);
  }
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    if (runner[t] >= 0) continue;
    const int a = tiling.rank_of(tasks[t].a);
    const int b = tiling.rank_of(tasks[t].b);
    runner[t] = at(b) < at(a) ? b : a;
    at(runner[t]) += load(tasks[t]);
  }
  return runner;
}

/// Runs a batch of tasks, each on one of the ranks that have its tiles. What the task needs of a
/// tile of another rank's is lent to the one that runs it, and comes back changed; messages are on
/// their way while tasks of a rank's own tiles run.
///
///     lender.add_sites(task, tile, sites): the sites of one of its tiles that the task needs
///     lender.load(task): about how long it takes
///     lender.put(writer, site, rank), lender.take(reader, site, rank): what there is of a site, to
///     or from another rank
template <class Lender, class Body>
void run_on_ranks(const Arena& arena, const Tiling& tiling, std::span<const Schedule::Task> tasks,
                  Lender&& lender, const Body& body) {
  using Task = Schedule::Task;
  Ranks& ranks = *tiling.ranks();
  std::vector<Task> own;
  std::vector<Task> with_others;
  std::map<int, std::vector<const Task*>> lent;  // by the rank that runs them
  std::set<int> borrowed;                        // the ranks whose tiles are needed
  const std::vector<int> runner =
      runners(tiling, tasks, [&](const Task& task) { return lender.load(task); });
  for (std::size_t t = 0; t < tasks.size(); ++t) {
    const Task& task = tasks[t];
    const bool has_a = tiling.is_own(task.a);
    const bool has_b = tiling.is_own(task.b);
    if (has_a && has_b) {
      own.push_back(task);
    } else if (has_a || has_b) {
      const int other = tiling.rank_of(has_a ? task.b : task.a);
      if (runner[t] == ranks.rank()) {
        with_others.push_back(task);
        borrowed.insert(other);
      } else {
        lent[other].push_back(&task);
      }
    }
  }
  const auto send = [&](int rank, const std::vector<SiteNumber>& sites) {
    ByteWriter message;
    message.put(sites);
    for (const SiteNumber site : sites) lender.put(message, site, rank);
    ranks.send(rank, std::move(message.bytes));
  };
  const auto receive = [&](int rank) {
    const Ranks::Bytes bytes = ranks.receive(rank);
    ByteReader message(bytes);
    std::vector<SiteNumber> sites;
    message.get(sites);
    for (const SiteNumber site : sites) lender.take(message, site, rank);
    return sites;
  };
  for (const auto& [rank, theirs] : lent) {
    std::vector<SiteNumber> sites;
    for (const Task* task : theirs) {
      lender.add_sites(*task, tiling.is_own(task->a) ? task->a : task->b, sites);
    }
    send(rank, sites);
  }
  // Work on both sides of a wait: for what others lend, and for what they give back.
  const std::span<const Task> all_own(own);
  const std::span<const Task> first_half = all_own.first(own.size() / 2);
  Schedule::run_batch(arena, tiling, first_half, body);
  std::map<int, std::vector<SiteNumber>> guests;
  for (const int rank : borrowed) guests[rank] = receive(rank);
  Schedule::run_batch(arena, tiling, std::span<const Task>(with_others), body);
  for (const auto& [rank, sites] : guests) send(rank, sites);
  Schedule::run_batch(arena, tiling, all_own.subspan(first_half.size()), body);
  for (const auto& [rank, theirs] : lent) receive(rank);
}

}  // namespace ccvt
