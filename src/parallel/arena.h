#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <type_traits>

#include "parallel/stop.h"

namespace ccvt {

/// A private pool of workers. Runs independent items; what an item computes must not depend on the
/// worker or on the order of items, so that the number of threads cannot change a result.
class Arena {
 public:
  /// `threads` workers, the caller included; 0: one per processor. The caller waits in for_each().
  /// `stop`, which must outlive the arena, ends loops by throwing Stopped between two ranges.
  explicit Arena(int threads, Stop* stop = nullptr);
  ~Arena();
  Arena(Arena&&) noexcept;
  Arena& operator=(Arena&&) noexcept;

  /// Workers in use: never more than processors with the TBB backend.
  [[nodiscard]] int threads() const { return threads_; }

  /// For loops of its owner: see Stop::check().
  void check() const {
    if (stop_ != nullptr) stop_->check();
  }

  /// Calls body(begin, end, worker) for consecutive ranges of at most `grain` items that cover
  /// 0..count-1. `worker` < threads() is not shared by two ranges at the same time.
  /// An exception thrown by `body` is passed on once all ranges have ended.
  template <class Body>
  void for_ranges(std::size_t count, std::size_t grain, Body&& body) const {
    if (count == 0) return;
    if (threads_ == 1 || count <= grain) {
      if (stop_ == nullptr) return body(std::size_t{0}, count, 0);
      for (std::size_t begin = 0; begin < count; begin += grain) {
        check();
        body(begin, std::min(begin + grain, count), 0);
      }
      return;
    }
    struct Context {
      std::remove_reference_t<Body>& body;
      const Arena& arena;
    };
    Context context{body, *this};
    run(
        count, grain,
        [](void* given, std::size_t begin, std::size_t end, int worker) {
          const auto& [work, arena] = *static_cast<Context*>(given);
          arena.check();
          work(begin, end, worker);
        },
        &context);
  }

  /// Calls body(item) for each item 0..count-1, `grain` of them a task.
  template <class Body>
  void for_each(std::size_t count, std::size_t grain, Body&& body) const {
    for_ranges(count, grain, [&body](std::size_t begin, std::size_t end, int) {
      for (std::size_t i = begin; i < end; ++i) body(i);
    });
  }

 private:
  using RangeFunction = void (*)(void*, std::size_t, std::size_t, int);
  void run(std::size_t count, std::size_t grain, RangeFunction function, void* context) const;

  struct Backend;
  int threads_ = 1;
  Stop* stop_ = nullptr;
  std::unique_ptr<Backend> backend_;
};

}  // namespace ccvt
