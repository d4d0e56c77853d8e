// The backend for ThreadSanitizer: the stock TBB library is not instrumented, and either floods the
// sanitizer with false alarms or, when those are suppressed, hides real races.
#ifdef CCVT_PARALLEL_THREADS

#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#include "parallel/arena.h"

namespace ccvt {

struct Arena::Backend {};

Arena::Arena(int threads, Stop* stop) : stop_(stop) {
  const int processors = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  threads_ = threads <= 0 ? processors : threads;
}

Arena::~Arena() = default;
Arena::Arena(Arena&&) noexcept = default;
Arena& Arena::operator=(Arena&&) noexcept = default;

void Arena::run(std::size_t count, std::size_t grain, RangeFunction function, void* context) const {
  std::atomic<std::size_t> next{0};
  std::mutex failure_mutex;
  std::exception_ptr failure;
  const auto work = [&](int worker) {
    for (std::size_t begin = next.fetch_add(grain); begin < count; begin = next.fetch_add(grain)) {
      try {
        function(context, begin, std::min(begin + grain, count), worker);
      } catch (...) {
        const std::lock_guard lock(failure_mutex);
        if (!failure) failure = std::current_exception();
      }
    }
  };
  std::vector<std::thread> helpers;
  for (int worker = 1; worker < threads_; ++worker) helpers.emplace_back(work, worker);
  work(0);
  for (std::thread& helper : helpers) helper.join();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace ccvt

#endif
