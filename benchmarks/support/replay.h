#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <iterator>
#include <map>
#include <numeric>
#include <queue>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/summary.h"
#include "support/statistics.h"

namespace ccvt::bench {

/// How long tasks take on so many workers when each takes the next one as soon as it is free.
inline double list_schedule(std::span<const float> tasks, int workers) {
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
  for (int w = 0; w < workers; ++w) free_at.push(0);
  double end = 0;
  for (const float task : tasks) {
    const double done = free_at.top() + double{task};
    free_at.pop();
    free_at.push(done);
    end = std::max(end, done);
  }
  return end;
}

/// The loops of one run on one thread, as Options::on_loop tells of them, and its phases. What it
/// takes to go from one task to the next, most of it the clock, is part of each.
struct RecordedRun {
  struct Loop {
    std::string phase;
    double seconds = 0;        ///< from its begin to its end
    std::vector<float> tasks;  ///< seconds of each
  };
  std::vector<Loop> loops;
  std::vector<PhaseRecord> phases;

  void listen(const LoopRecord& loop) {
    Loop& own = loops.emplace_back(
        Loop{loop.phase, loop.end - loop.begin, {loop.tasks.begin(), loop.tasks.end()}});
    const double in_tasks = std::accumulate(own.tasks.begin(), own.tasks.end(), 0.0);
    const auto between =
        static_cast<float>(own.seconds - in_tasks) / static_cast<float>(own.tasks.size());
    for (float& task : own.tasks) task += between;
  }
  [[nodiscard]] double seconds_in_loops(const std::string& phase) const {
    double sum = 0;
    for (const Loop& loop : loops) sum += loop.phase == phase ? loop.seconds : 0;
    return sum;
  }
};

/// What a run of one thread would take on more workers: its loops are scheduled anew, all else
/// stays. The runs given are of one problem, so that they have the same loops and tasks: a task
/// takes the median of what it took in them, as one that the system has interrupted would stand
/// for much more than itself.
class Replay {
 public:
  static constexpr std::array kWorkers{2, 4, 8, 16, 32, 64};

  /// Throws std::logic_error unless the runs have the same loops.
  explicit Replay(std::span<const RecordedRun> runs) {
    for (std::size_t l = 0; l < runs[0].loops.size(); ++l) add_loop(medians(runs, l));
    for (std::size_t p = 0; p < runs[0].phases.size(); ++p) {
      const std::string& name = runs[0].phases[p].name;
      std::vector<double> serial;
      for (const RecordedRun& run : runs) {
        serial.push_back(run.phases[p].seconds - run.seconds_in_loops(name));
      }
      phases_[name].serial = std::max(0.0, median(serial));
    }
  }

  /// On one worker.
  [[nodiscard]] double seconds() const {
    double sum = 0;
    for (const auto& [name, phase] : phases_) sum += phase.work + phase.serial;
    return sum;
  }
  /// `barrier`: what the end of a loop costs two workers; more of them wait for each other in a
  /// tree. `slowdown`: of tasks, beside others.
  [[nodiscard]] double seconds_on(std::size_t k, double barrier, double slowdown) const {
    double sum = barrier * std::log2(kWorkers[k]) * loops_;
    for (const auto& [name, phase] : phases_) sum += phase.serial + slowdown * phase.parallel[k];
    return sum;
  }
  /// On one worker.
  [[nodiscard]] double seconds_in(const std::string& phase) const {
    return phases_.at(phase).work + phases_.at(phase).serial;
  }
  [[nodiscard]] double work_in(const std::string& phase) const { return phases_.at(phase).work; }
  [[nodiscard]] double serial_in(const std::string& phase) const {
    return phases_.at(phase).serial;
  }
  /// On so many workers, without what is serial.
  [[nodiscard]] double parallel_in(const std::string& phase, std::size_t k) const {
    return phases_.at(phase).parallel[k];
  }

 private:
  struct Phase {
    double work = 0;
    double serial = 0;
    std::array<double, kWorkers.size()> parallel{};
  };

  /// Loop l, each task with its median.
  static RecordedRun::Loop medians(std::span<const RecordedRun> runs, std::size_t l) {
    RecordedRun::Loop loop = runs[0].loops[l];
    for (const RecordedRun& run : runs) {
      if (run.loops.size() != runs[0].loops.size() || run.loops[l].phase != loop.phase ||
          run.loops[l].tasks.size() != loop.tasks.size()) {
        throw std::logic_error("replay: the runs are not of one problem");
      }
    }
    std::vector<float> times(runs.size());
    for (std::size_t t = 0; t < loop.tasks.size(); ++t) {
      for (std::size_t r = 0; r < runs.size(); ++r) times[r] = runs[r].loops[l].tasks[t];
      std::sort(times.begin(), times.end());
      loop.tasks[t] = times[times.size() / 2];
    }
    return loop;
  }

  void add_loop(const RecordedRun::Loop& loop) {
    Phase& phase = phases_[loop.phase];
    for (const float task : loop.tasks) phase.work += double{task};
    for (std::size_t k = 0; k < kWorkers.size(); ++k) {
      phase.parallel[k] += list_schedule(loop.tasks, kWorkers[k]);
    }
    if (loop.tasks.size() > 1) ++loops_;
  }

  std::map<std::string, Phase> phases_;
  int loops_ = 0;  ///< that have an end to wait for
};

}  // namespace ccvt::bench
