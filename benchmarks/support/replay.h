#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <queue>
#include <span>
#include <string>
#include <vector>

#include "ccvt/summary.h"

namespace ccvt::bench {

/// How long tasks take on so many workers when each takes the next one as soon as it is free.
inline double list_schedule(std::span<const float> tasks, int workers) {
  std::priority_queue<double, std::vector<double>, std::greater<>> free_at;
  for (int w = 0; w < workers; ++w) free_at.push(0);
  double end = 0;
  for (const float task : tasks) {
    const double done = free_at.top() + static_cast<double>(task);
    free_at.pop();
    free_at.push(done);
    end = std::max(end, done);
  }
  return end;
}

/// What a run of one thread would take on more workers: its loops are scheduled anew, all else
/// stays. Give listen() to Options::on_loop.
class Replay {
 public:
  static constexpr std::array kWorkers{2, 4, 8, 16, 32, 64};

  void listen(const LoopRecord& loop) {
    Phase& phase = phases_[loop.phase];
    for (const float task : loop.tasks) phase.work += static_cast<double>(task);
    for (std::size_t k = 0; k < kWorkers.size(); ++k) {
      phase.parallel[k] += list_schedule(loop.tasks, kWorkers[k]);
      if (loop.tasks.size() > 1) barriers_[k] += std::log2(kWorkers[k]);
    }
  }

  /// Of a run that took `seconds`. `barrier`: what the end of a loop costs two workers; more of
  /// them wait for each other in a tree. `slowdown`: of tasks, beside others.
  [[nodiscard]] double seconds_on(std::size_t k, double seconds, double barrier,
                                  double slowdown) const {
    double work = 0;
    double parallel = 0;
    for (const auto& [name, phase] : phases_) {
      work += phase.work;
      parallel += phase.parallel[k];
    }
    return seconds - work + slowdown * parallel + barrier * barriers_[k];
  }
  /// In tasks, by phase.
  [[nodiscard]] double work_in(const std::string& phase) const {
    const auto found = phases_.find(phase);
    return found != phases_.end() ? found->second.work : 0;
  }
  /// On so many workers, without what is serial, by phase.
  [[nodiscard]] double parallel_in(const std::string& phase, std::size_t k) const {
    const auto found = phases_.find(phase);
    return found != phases_.end() ? found->second.parallel[k] : 0;
  }

 private:
  struct Phase {
    double work = 0;
    std::array<double, kWorkers.size()> parallel{};
  };
  std::map<std::string, Phase> phases_;
  std::array<double, kWorkers.size()> barriers_{};
};

}  // namespace ccvt::bench
