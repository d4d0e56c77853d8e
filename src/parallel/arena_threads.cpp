// The backend for ThreadSanitizer: the stock TBB library is not instrumented, and either floods the
// sanitizer with false alarms or, when those are suppressed, hides real races.
#ifdef CCVT_PARALLEL_THREADS

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "parallel/arena.h"

namespace ccvt {

struct Arena::Backend {};

Arena::Arena(int threads, Stop* stop, Recorder* recorder) : stop_(stop), recorder_(recorder) {
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  threads_ = threads <= 0 ? processors : threads;
}

Arena::~Arena() = default;
Arena::Arena(Arena&&) noexcept = default;
Arena& Arena::operator=(Arena&&) noexcept = default;

void Arena::run_on_all(const Range& range, Recorder::Loop* timing) const {
  std::atomic<std::size_t> next{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  const std::size_t ranges = range.ranges();
  const auto work = [&](int worker) {
    try {
      for (std::size_t k = next++; k < ranges; k = next++) range(k, worker, timing);
    } catch (...) {
      next = ranges;
      const std::lock_guard lock(failure_mutex);
      if (!failure) failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> helpers;
    const int workers = static_cast<int>(std::min(static_cast<std::size_t>(threads()), ranges));
    try {
      for (int worker = 1; worker < workers; ++worker) helpers.emplace_back(work, worker);
    } catch (...) {
      next = ranges;  // those that have started end
      throw;
    }
    work(0);
  }
  if (failure) std::rethrow_exception(failure);
}

std::string thread_library() { return "std::thread"; }

}  // namespace ccvt

#endif
