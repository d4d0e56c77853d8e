#ifdef CCVT_PARALLEL_TBB

#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include "parallel/arena.h"

namespace ccvt {

struct Arena::Backend {
  explicit Backend(int threads) : arena(threads) {}
  tbb::task_arena arena;
};

Arena::Arena(int threads, Stop* stop) : stop_(stop) {
  // Asking TBB for more workers than processors makes it print a warning, and gains nothing.
  const int processors = std::max(1, tbb::info::default_concurrency());
  threads_ = threads <= 0 ? processors : std::min(threads, processors);
  if (threads_ > 1) backend_ = std::make_unique<Backend>(threads_);
}

Arena::~Arena() = default;
Arena::Arena(Arena&&) noexcept = default;
Arena& Arena::operator=(Arena&&) noexcept = default;

void Arena::run(std::size_t count, std::size_t grain, RangeFunction function, void* context) const {
  backend_->arena.execute([=] {
    tbb::task_group group;
    for (std::size_t begin = 0; begin < count; begin += grain) {
      const std::size_t end = std::min(begin + grain, count);
      group.run(
          [=] { function(context, begin, end, tbb::this_task_arena::current_thread_index()); });
    }
    group.wait();
  });
}

}  // namespace ccvt

#endif
