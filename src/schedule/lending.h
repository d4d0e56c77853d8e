#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <map>
#include <numeric>
#include <set>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "schedule/in_order.h"
#include "schedule/schedule.h"

namespace ccvt {

/// The ranks that run the tasks of batches, each one of those that have its tiles: the one that has
/// less to do, in all batches by then. The same on all ranks. Load(task): how long a task takes.
class Runners {
 public:
  explicit Runners(const Tiling& tiling)
      : tiling_(tiling), loads_(static_cast<std::size_t>(tiling.ranks()->count()), 0) {}

  template <class Load>
  std::vector<int> deal(std::span<const Schedule::Task> tasks, const Load& load) {
    std::vector<int> runner;
    runner.reserve(tasks.size());
    for (const Schedule::Task& task : tasks) {
      const int a = tiling_.rank_of(task.a);
      runner.push_back(a == tiling_.rank_of(task.b) ? a : kOpen);
      if (runner.back() != kOpen) at(a) += load(task);
    }
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      if (runner[t] != kOpen) continue;
      const int a = tiling_.rank_of(tasks[t].a);
      const int b = tiling_.rank_of(tasks[t].b);
      runner[t] = at(b) < at(a) ? b : a;
      at(runner[t]) += load(tasks[t]);
    }
    return runner;
  }

 private:
  static constexpr int kOpen = -1;
  std::size_t& at(int rank) { return loads_[static_cast<std::size_t>(rank)]; }

  const Tiling& tiling_;
  std::vector<std::size_t> loads_;  ///< by rank
};

/// Runs batches of tasks by several ranks, each task by one of those that have its tiles. What it
/// needs of a tile of another rank's is lent to the one that runs it, and comes back changed. The
/// tasks of a tile run in the order of the batches, but a rank that waits for another goes on with
/// later batches as far as it can: who has more to do in one batch has less in another.
///
///     lender.has_work(task): false where the task has nothing to do: it is left out. The same on
///     both its ranks, which ask at different times: no other task may change it
///     lender.add_sites(task, tile, sites): the sites of one of its tiles that the task needs
///     lender.load(task): about how long it takes
///     lender.lacks(rank, site): whether another rank lacks something of a site as it is here; what
///     it does not lack is not sent
///     lender.put(writer, site, rank), lender.take(reader, site, rank): what there is of a site, to
///     or from another rank
///     work(tasks): runs tasks that have no tile in common
template <class Lender, class Work>
class RankBatches {
 public:
  using Task = Schedule::Task;
  using Tasks = std::span<const Task>;

  /// All of which must outlive it. While more than `most_waiting` tasks wait, no batch is begun.
  RankBatches(const Tiling& tiling, const Lender& lender, const Work& work, int threads,
              std::size_t most_waiting)
      : most_waiting_(most_waiting),
        ranks_(*tiling.ranks()),
        tiling_(tiling),
        lender_(lender),
        work_(work),
        threads_(static_cast<std::size_t>(threads)),
        runners_(tiling),
        lines_(tiling.count()),
        awaited_(static_cast<std::size_t>(ranks_.count()), 0) {}

  /// Runs the tasks of the next batch, those that can be run now.
  void run(Tasks tasks) {
    while (waiting_.size() > most_waiting_) wait();
    const std::vector<Task> ready = deal(tasks);
    ++batch_;
    take_what_has_come();
    advance();
    std::size_t left = load_of(ready);
    const std::size_t piece = left / std::clamp<std::size_t>(ready.size() / (8 * threads_), 1, 8);
    for (std::size_t begin = 0, end = 0; begin < ready.size(); begin = end) {
      const std::size_t least = is_alone() ? left : std::min(piece, left);
      std::size_t load = 0;
      while (end < ready.size() && (load < least || end == begin)) {
        load += lender_.load(ready[end++]);
      }
      if (load == left) end = ready.size();
      left -= load;
      work_(Tasks(ready).subspan(begin, end - begin));
      take_what_has_come();
      advance();
    }
  }

  /// Runs what is left: after the last batch.
  void finish() {
    while (!waiting_.empty()) wait();
  }

 private:
  enum class Role : std::uint8_t { own, lends, borrows };

  struct Waiting;
  /// A place in the line of a tile whose tasks have to wait.
  struct Place {
    Tile tile;
    Waiting* who;
    Place* next = nullptr;
  };
  struct Line {
    Place* first = nullptr;
    Place* last = nullptr;
  };
  using List = std::list<Waiting>;

  /// Tasks that wait: for others of their tiles, or for a message.
  struct Waiting {
    Role role;
    std::uint32_t batch;
    int rank;  ///< the other one; its own, of tasks of own tiles
    std::vector<Task> tasks{};
    std::vector<Place> places{};  ///< of own tiles
    std::size_t behind = 0;       ///< in how many lines it is not the first
    bool is_sent = false;         ///< what is lent
    bool has_come = false;        ///< what is awaited
    bool is_due = false;          ///< to be looked at: in due_
    typename List::iterator self{};
  };

  /// The tasks of own tiles that need not wait; all others wait.
  std::vector<Task> deal(Tasks tasks) {
    const std::vector<int> runner =
        runners_.deal(tasks, [this](const Task& task) { return lender_.load(task); });
    std::vector<Task> ready;
    List waiting;
    for (std::size_t t = 0; t < tasks.size(); ++t) {
      const Task& task = tasks[t];
      const bool has_a = tiling_.is_own(task.a);
      const bool has_b = tiling_.is_own(task.b);
      if (has_a && has_b) {
        if (is_free(task.a) && is_free(task.b)) {
          ready.push_back(task);
        } else {
          waiting.push_back({Role::own, batch_, ranks_.rank(), {task}});
        }
      } else if ((has_a || has_b) && lender_.has_work(task)) {
        const Role role = runner[t] == ranks_.rank() ? Role::borrows : Role::lends;
        const int rank = tiling_.rank_of(has_a ? task.b : task.a);
        auto with = with_others_.try_emplace({role, rank, batch_}, nullptr).first;
        if (with->second == nullptr) {
          waiting.push_back({role, batch_, rank});
          with->second = &waiting.back();
        }
        with->second->tasks.push_back(task);
      }
    }
    for (auto w = waiting.begin(); w != waiting.end(); ++w) {
      w->self = w;
      line_up(*w);
      // A loan may have come before its batch was dealt here.
      if (w->role != Role::borrows) continue;
      w->has_come = early_.erase({w->rank, w->batch}) > 0;
      if (!w->has_come) ++awaited(w->rank);
    }
    waiting_.splice(waiting_.end(), waiting);
    return ready;
  }

  [[nodiscard]] bool is_free(Tile tile) const { return lines_[tile].first == nullptr; }
  void line_up(Waiting& w) {
    for (const Task& task : w.tasks) {
      if (tiling_.is_own(task.a)) w.places.push_back({task.a, &w});
      if (tiling_.is_own(task.b) && task.b != task.a) w.places.push_back({task.b, &w});
    }
    for (Place& place : w.places) {
      Line& line = lines_[place.tile];
      w.behind += line.first != nullptr ? 1 : 0;
      (line.first != nullptr ? line.last->next : line.first) = &place;
      line.last = &place;
    }
    if (w.behind == 0) look_at(w);
  }
  void look_at(Waiting& w) {
    if (!std::exchange(w.is_due, true)) due_.push_back(&w);
  }
  /// It is through.
  void leave(const Waiting& w) {
    for (const Place& place : w.places) {
      lines_[place.tile].first = place.next;
      if (place.next != nullptr && --place.next->who->behind == 0) look_at(*place.next->who);
    }
    if (w.role != Role::own) with_others_.erase({w.role, w.rank, w.batch});
    waiting_.erase(w.self);
  }

  [[nodiscard]] std::size_t load_of(Tasks tasks) const {
    return std::accumulate(
        tasks.begin(), tasks.end(), std::size_t{0},
        [this](std::size_t sum, const Task& task) { return sum + lender_.load(task); });
  }
  [[nodiscard]] bool is_alone() const {
    return std::all_of(awaited_.begin(), awaited_.end(),
                       [](int messages) { return messages == 0; });
  }

  /// Does what can be done without waiting.
  void advance() {
    while (!due_.empty()) {
      std::vector<Waiting*> own;  // that have no tile in common, as they are the first of theirs
      std::vector<Task> tasks;
      for (Waiting* const w : std::exchange(due_, {})) {
        w->is_due = false;
        if (w->role == Role::own) {
          own.push_back(w);
          tasks.push_back(w->tasks.front());
        } else if (goes_on(*w)) {
          leave(*w);
        }
      }
      if (!own.empty()) work_(tasks);
      for (Waiting* const w : own) leave(*w);
    }
  }
  /// Whether tasks with another rank's tiles are through.
  bool goes_on(Waiting& with) {
    if (with.role == Role::borrows) {
      if (!with.has_come) return false;
      const std::vector<SiteNumber> guests = sites_of(with);  // tasks may be shorter afterwards
      work_(with.tasks);
      send(with, guests);
      return true;
    }
    if (!with.is_sent) {
      send(with, sites_of(with));
      with.is_sent = true;
      ++awaited(with.rank);
    }
    return with.has_come;
  }
  /// That are lent.
  [[nodiscard]] std::vector<SiteNumber> sites_of(const Waiting& with) const {
    const bool lends = with.role == Role::lends;
    std::vector<SiteNumber> sites;
    for (const Task& task : with.tasks) {
      lender_.add_sites(task, tiling_.is_own(task.a) == lends ? task.a : task.b, sites);
    }
    return sites;
  }

  /// Does what can be done once a message has come.
  void wait() {
    if (!take_what_has_come()) take(awaited_rank());
    advance();
  }
  /// The rank to wait for. Of what waits longest, which is not tasks of own tiles, loans come
  /// first: they need nothing of this rank, while what it has lent may come back only after it has
  /// given back what it has borrowed.
  [[nodiscard]] int awaited_rank() const {
    const Waiting& first = waiting_.front();
    for (const Waiting& w : waiting_) {
      if (w.batch != first.batch) break;
      if (w.role == Role::borrows && !w.has_come) return w.rank;
    }
    return first.rank;
  }
  bool take_what_has_come() {
    bool any = false;
    for (int rank = 0; rank < ranks_.count(); ++rank) {
      for (; awaited(rank) > 0 && ranks_.has_come(rank); any = true) take(rank);
    }
    return any;
  }

  void send(const Waiting& with, const std::vector<SiteNumber>& sites) {
    ByteWriter message;
    message.put(with.role);
    message.put(with.batch);
    for (const SiteNumber site : sites) {
      if (!lender_.lacks(with.rank, site)) continue;
      message.put(site);
      lender_.put(message, site, with.rank);
    }
    ranks_.send(with.rank, std::move(message.bytes));
  }
  /// Waits for the next message of a rank.
  void take(int rank) {
    const Ranks::Bytes bytes = ranks_.receive(rank);
    ByteReader message(bytes);
    // What the other one lends, this one borrows.
    const Role role = message.get<Role>() == Role::lends ? Role::borrows : Role::lends;
    const auto batch = message.get<std::uint32_t>();
    while (!message.done()) {
      const auto site = message.get<SiteNumber>();
      lender_.take(message, site, rank);
    }
    const auto found = with_others_.find({role, rank, batch});
    if (found == with_others_.end()) {
      early_.emplace(rank, batch);
      return;
    }
    Waiting& with = *found->second;
    with.has_come = true;
    --awaited(rank);
    if (with.behind == 0) look_at(with);
  }

  [[nodiscard]] int& awaited(int rank) { return awaited_[static_cast<std::size_t>(rank)]; }

  std::size_t most_waiting_;
  Ranks& ranks_;
  const Tiling& tiling_;
  Lender lender_;
  const Work& work_;
  std::size_t threads_;
  Runners runners_;
  std::uint32_t batch_ = 0;    ///< the next one
  List waiting_;               ///< in the order of the batches
  std::vector<Line> lines_;    ///< by tile
  std::vector<Waiting*> due_;  ///< that are behind nobody, and may go on
  std::map<std::tuple<Role, int, std::uint32_t>, Waiting*> with_others_;
  std::vector<int> awaited_;  ///< by rank: messages of batches that have been dealt
  /// Loans of batches that have not been dealt here yet, by rank and batch.
  std::set<std::pair<int, std::uint32_t>> early_;
};

/// Calls body(task, worker) for the tasks of all batches of a source, which is read like a
/// Schedule; before each batch, go_on() says whether to, the same on all ranks; where several
/// threads run a Schedule (see InOrder), before the first. The tasks of a batch have no tile in
/// common. Of several ranks, each runs some (see RankBatches); after each
/// task messages get on, where ranks are MessageProgress.
template <class Source, class Lender, class Body, class GoOn>
void run_batches(const Arena& arena, const Tiling& tiling, Source& source, const Lender& lender,
                 const Body& body, const GoOn& go_on) {
  if (tiling.ranks() == nullptr) {
    if constexpr (std::is_same_v<std::remove_const_t<Source>, Schedule>) {
      if (arena.threads() > 1) {
        if (!go_on()) return;
        InOrder(source, tiling, [&](const Schedule::Task& task) {
          return lender.load(task);
        }).run(arena, body);
        return;
      }
    }
    for (std::size_t b = 0; b < source.batch_count() && go_on(); ++b) {
      Schedule::run_batch(arena, tiling, source.batch(b), body);
    }
    return;
  }
  auto* const progress = dynamic_cast<MessageProgress*>(tiling.ranks());
  const auto work = [&](std::span<const Schedule::Task> tasks) {
    Schedule::run_batch(arena, tiling, tasks, [&](const Schedule::Task& task, int worker) {
      body(task, worker);
      if (progress != nullptr) progress->progress();
    });
  };
  constexpr std::size_t kMostWaiting = 1 << 14;  // bounds the memory
  RankBatches batches(tiling, lender, work, arena.threads(), kMostWaiting);
  for (std::size_t b = 0; b < source.batch_count() && go_on(); ++b) batches.run(source.batch(b));
  batches.finish();
}

}  // namespace ccvt
