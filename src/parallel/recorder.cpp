#include "parallel/recorder.h"

#include <numeric>

namespace ccvt {

const char* name_of(Phase phase) {
  static constexpr std::array<const char*, kPhases> names{
      "other", "sites", "levels",   "nearest", "join",   "graph",   "potential",
      "flow",  "lists", "schedule", "swap",    "update", "descent", "mend"};
  return names[static_cast<std::size_t>(phase)];
}

Phase Recorder::enter(Phase phase) {
  const double time = now();
  if (!rests_) shares_[static_cast<std::size_t>(phase_)].seconds += time - since_;
  since_ = time;
  const Phase before = phase_;
  phase_ = phase;
  return before;
}

void Recorder::add(const std::array<Share, kPhases>& earlier) {
  for (std::size_t k = 0; k < kPhases; ++k) {
    shares_[k].seconds += earlier[k].seconds;
    shares_[k].work_seconds += earlier[k].work_seconds;
    shares_[k].loops += earlier[k].loops;
    shares_[k].tasks += earlier[k].tasks;
  }
}

Recorder::Loop& Recorder::begin_loop(std::size_t tasks) {
  loop_.phase = phase_;
  loop_.tasks.assign(tasks, 0);
  loop_.begin = now();
  return loop_;
}

void Recorder::end_loop() {
  loop_.end = now();
  Share& share = shares_[static_cast<std::size_t>(phase_)];
  share.work_seconds += std::accumulate(loop_.tasks.begin(), loop_.tasks.end(), 0.0);
  ++share.loops;
  share.tasks += static_cast<std::int64_t>(loop_.tasks.size());
  if (!listener_) return;
  const auto told = Clock::now();
  listener_(loop_);
  start_ += Clock::now() - told;  // none of the run's time
}

}  // namespace ccvt
