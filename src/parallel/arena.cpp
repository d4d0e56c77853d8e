#include "parallel/arena.h"

#include <chrono>
#include <utility>

namespace ccvt {
namespace {

/// The arena whose loop this thread works for, and as which worker.
struct Working {
  const void* arena = nullptr;
  int worker = 0;
  Recorder::Clock::duration waited{};  ///< in the range it works at
};
thread_local Working working;

}  // namespace

void Arena::Waiting::add(Recorder::Clock::duration waited) { working.waited += waited; }

void Arena::Range::operator()(std::size_t k, int worker, Recorder::Loop* timing) const {
  struct Restore {
    Working before;
    ~Restore() { working = before; }
  } const restore{std::exchange(working, Working{arena, worker})};
  const std::size_t begin = k * grain;
  const std::size_t end = std::min(begin + grain, count);
  if (timing == nullptr) return function(context, begin, end, worker);
  const auto start = Recorder::Clock::now();
  function(context, begin, end, worker);
  const auto worked = Recorder::Clock::now() - start - working.waited;
  timing->tasks[k] = std::chrono::duration<float>(worked).count();
}

void Arena::run_here(const Range& range, int worker, Recorder::Loop* timing) {
  for (std::size_t k = 0; k < range.ranges(); ++k) range(k, worker, timing);
}

void Arena::run(std::size_t count, std::size_t grain, RangeFunction function, void* context) const {
  const Range range{this, function, context, count, grain};
  if (working.arena == this) return run_here(range, working.worker, nullptr);
  Recorder::Loop* const timing =
      recorder_ != nullptr ? &recorder_->begin_loop(range.ranges()) : nullptr;
  if (threads_ == 1 || range.ranges() == 1) {
    run_here(range, 0, timing);
  } else {
    run_on_all(range, timing);
  }
  if (recorder_ != nullptr) recorder_->end_loop();
}

}  // namespace ccvt
