#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <set>
#include <span>
#include <utility>
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

/// Runs batches of tasks. Of several ranks, each task is run by one of those that have its tiles.
/// What it needs of a tile of another rank's is lent to the one that runs it, and comes back
/// changed. Messages are on their way while a rank's own tiles are worked on; what is lent may come
/// back as late as when the next task of its tile is to run, so that others need not wait for a
/// rank that is a little late in one batch; after each task, they get on, where ranks are
/// MessageProgress.
///
///     lender.has_work(task): false where the task has nothing to do: it is left out. The same on
///     both its ranks, which ask at different times: no other task may change it
///     lender.add_sites(task, tile, sites): the sites of one of its tiles that the task needs
///     lender.load(task): about how long it takes
///     lender.put(writer, site, rank), lender.take(reader, site, rank): what there is of a site, to
///     or from another rank
template <class Lender>
class BatchRun {
 public:
  using Task = Schedule::Task;
  using Tasks = std::span<const Task>;

  BatchRun(const Arena& arena, const Tiling& tiling, Lender lender)
      : arena_(arena),
        tiling_(tiling),
        lender_(std::move(lender)),
        progress_(dynamic_cast<MessageProgress*>(tiling.ranks())) {
    if (tiling.ranks() != nullptr) holder_.assign(tiling.count(), kHome);
  }

  /// Calls body(task, worker) for the tasks of the next batch, which have no tile in common.
  template <class Body>
  void run(Tasks tasks, const Body& body) {
    if (tiling_.ranks() == nullptr) return Schedule::run_batch(arena_, tiling_, tasks, body);
    const auto work = [&](Tasks some) {
      Schedule::run_batch(arena_, tiling_, some, [&](const Task& task, int worker) {
        body(task, worker);
        if (progress_ != nullptr) progress_->progress();
      });
    };
    Dealt dealt = deal(tasks);
    std::map<int, std::vector<Task>> lent_late;
    for (const auto& [rank, theirs] : dealt.lent) {
      if (std::all_of(theirs.begin(), theirs.end(), [&](const Task& t) { return are_home(t); })) {
        lend(rank, theirs);
      } else {
        lent_late[rank] = theirs;
      }
    }
    const auto late = std::stable_partition(dealt.own.begin(), dealt.own.end(),
                                            [&](const Task& task) { return are_home(task); });
    const Tasks ready(dealt.own.begin(), late);
    const Tasks first_half = ready.first(half_of(ready));
    work(first_half);
    for (const auto& [rank, theirs] : lent_late) {
      take_back_tiles(theirs);
      lend(rank, theirs);
    }
    std::map<int, std::vector<SiteNumber>> guests;
    for (const int rank : dealt.borrowed) {
      take_back(rank);  // what it gives back came before what it lends
      guests[rank] = receive(rank);
    }
    take_back_tiles(dealt.with_others);
    work(dealt.with_others);
    for (const auto& [rank, sites] : guests) send(rank, sites);
    work(ready.subspan(first_half.size()));
    const Tasks rest(late, dealt.own.end());
    take_back_tiles(rest);
    work(rest);
    for (const auto& [rank, theirs] : dealt.lent) {
      Away& away = away_[rank];
      ++away.messages;
      for (const Task& task : theirs) {
        away.tiles.push_back(own_tile(task));
        holder_[own_tile(task)] = rank;
      }
    }
  }

  /// Takes back what is still lent: after the last batch.
  void end() {
    while (!away_.empty()) take_back(away_.begin()->first);
  }

 private:
  static constexpr int kHome = -1;

  /// A batch as this rank sees it.
  struct Dealt {
    std::vector<Task> own;                  ///< of its tiles alone
    std::vector<Task> with_others;          ///< of one of its tiles, and run by it
    std::map<int, std::vector<Task>> lent;  ///< by the rank that runs them
    std::set<int> borrowed;                 ///< the ranks whose tiles are needed
  };

  /// What a rank has been lent.
  struct Away {
    std::vector<Tile> tiles;
    int messages = 0;  ///< with which it comes back
  };

  [[nodiscard]] Dealt deal(Tasks tasks) const {
    Dealt dealt;
    const std::vector<int> runner =
        runners(tiling_, tasks, [&](const Task& task) { return lender_.load(task); });
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const Task& task = tasks[t];
      const bool has_a = tiling_.is_own(task.a);
      const bool has_b = tiling_.is_own(task.b);
      if (has_a && has_b) {
        dealt.own.push_back(task);
      } else if ((has_a || has_b) && lender_.has_work(task)) {
        const int other = tiling_.rank_of(has_a ? task.b : task.a);
        if (runner[t] == tiling_.ranks()->rank()) {
          dealt.with_others.push_back(task);
          dealt.borrowed.insert(other);
        } else {
          dealt.lent[other].push_back(task);
        }
      }
    }
    return dealt;
  }

  /// How many of these tasks, from the first on, take half of the time.
  [[nodiscard]] std::size_t half_of(Tasks tasks) const {
    std::size_t all = 0;
    for (const Task& task : tasks) all += lender_.load(task);
    std::size_t count = 0;
    for (std::size_t done = 0; 2 * done < all; ++count) done += lender_.load(tasks[count]);
    return count;
  }

  [[nodiscard]] Tile own_tile(const Task& task) const {
    return tiling_.is_own(task.a) ? task.a : task.b;
  }
  [[nodiscard]] bool is_home(Tile tile) const { return holder_[tile] == kHome; }
  [[nodiscard]] bool are_home(const Task& task) const { return is_home(task.a) && is_home(task.b); }

  void lend(int rank, const std::vector<Task>& tasks) {
    std::vector<SiteNumber> sites;
    for (const Task& task : tasks) lender_.add_sites(task, own_tile(task), sites);
    send(rank, sites);
  }
  /// Waits for what is lent of the tiles of these tasks.
  void take_back_tiles(Tasks tasks) {
    for (const Task& task : tasks) {
      for (const Tile tile : {task.a, task.b}) {
        if (!is_home(tile)) take_back(holder_[tile]);
      }
    }
  }
  /// Waits for all that is lent to a rank.
  void take_back(int rank) {
    const auto away = away_.find(rank);
    if (away == away_.end()) return;
    for (; away->second.messages > 0; --away->second.messages) receive(rank);
    for (const Tile tile : away->second.tiles) holder_[tile] = kHome;
    away_.erase(away);
  }

  void send(int rank, const std::vector<SiteNumber>& sites) {
    ByteWriter message;
    message.put(sites);
    for (const SiteNumber site : sites) lender_.put(message, site, rank);
    tiling_.ranks()->send(rank, std::move(message.bytes));
  }
  std::vector<SiteNumber> receive(int rank) {
    const Ranks::Bytes bytes = tiling_.ranks()->receive(rank);
    ByteReader message(bytes);
    std::vector<SiteNumber> sites;
    message.get(sites);
    for (const SiteNumber site : sites) lender_.take(message, site, rank);
    return sites;
  }

  const Arena& arena_;
  const Tiling& tiling_;
  Lender lender_;
  MessageProgress* progress_;  ///< of the ranks, or null
  std::vector<int> holder_;    ///< by tile, kHome or the rank that it is lent to
  std::map<int, Away> away_;
};

}  // namespace ccvt
