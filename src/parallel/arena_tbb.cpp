#ifdef CCVT_PARALLEL_TBB

#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>
#include <tbb/version.h>

#include <atomic>
#include <string>

#include "parallel/arena.h"

namespace ccvt {

struct Arena::Backend {
  explicit Backend(int threads) : arena(threads) {}
  tbb::task_arena arena;
};

Arena::Arena(int threads, Stop* stop, Recorder* recorder) : stop_(stop), recorder_(recorder) {
  // Asking TBB for more workers than processors makes it print a warning, and gains nothing.
  const int processors = std::max(1, tbb::info::default_concurrency());
  threads_ = threads <= 0 ? processors : std::min(threads, processors);
  if (threads_ > 1) backend_ = std::make_unique<Backend>(threads_);
}

Arena::~Arena() = default;
Arena::Arena(Arena&&) noexcept = default;
Arena& Arena::operator=(Arena&&) noexcept = default;

/// A task for each worker, which takes ranges in their order: the first ranges should be the
/// longest. After an exception no more are taken.
void Arena::run_on_all(const Range& range, Recorder::Loop* timing) const {
  backend_->arena.execute([&] {
    std::atomic<std::size_t> next{0};
    const std::size_t ranges = range.ranges();
    const auto work = [&] {
      const int worker = tbb::this_task_arena::current_thread_index();
      try {
        for (std::size_t k = next++; k < ranges; k = next++) range(k, worker, timing);
      } catch (...) {
        next = ranges;
        throw;
      }
    };
    tbb::task_group group;
    const std::size_t helpers = std::min(static_cast<std::size_t>(threads_), ranges) - 1;
    for (std::size_t h = 0; h < helpers; ++h) group.run(work);
    group.run_and_wait(work);
  });
}

std::string thread_library() {
  return "oneTBB " + std::to_string(TBB_VERSION_MAJOR) + "." + std::to_string(TBB_VERSION_MINOR);
}

}  // namespace ccvt

#endif
