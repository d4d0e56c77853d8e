// The backend for ThreadSanitizer: the stock TBB library is not instrumented, and either floods the
// sanitizer with false alarms or, when those are suppressed, hides real races.
#ifdef CCVT_PARALLEL_THREADS

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
  std::vector<std::thread> helpers;
  for (int worker = 1; worker < threads_; ++worker) helpers.emplace_back(work, worker);
  work(0);
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

std::string thread_library() { return "std::thread"; }

}  // namespace ccvt

#endif
