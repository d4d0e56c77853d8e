#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <type_traits>

#include "ccvt/ranks.h"
#include "parallel/recorder.h"
#include "parallel/stop.h"

namespace ccvt {

/// A private pool of workers. Runs independent items; what an item computes must not depend on the
/// worker or on the order of items, so that the number of threads cannot change a result. What
/// phases do with it beyond that is in parallel/loops.h.
///
/// A loop that is started in the body of another loop of the same arena runs its ranges one after
/// the other on the worker that starts it, with that worker's number.
class Arena {
 public:
  /// `threads` workers, the caller included; 0: one per processor. The caller waits in for_each().
  /// `stop`, which must outlive the arena, ends loops by throwing Stopped between two ranges;
  /// `recorder`, which must too, is told of each loop that is not inside another.
  explicit Arena(int threads, Stop* stop = nullptr, Recorder* recorder = nullptr);
  ~Arena();
  Arena(Arena&&) noexcept;
  Arena& operator=(Arena&&) noexcept;

  /// Workers in use: never more than processors with the TBB backend.
  [[nodiscard]] int threads() const { return threads_; }
  /// For how many workers work should be divided: those in use; many for one that someone listens
  /// to, who wants to know what they would do.
  [[nodiscard]] std::size_t workers_in_mind() const {
    constexpr std::size_t kMany = 64;
    const bool many = threads_ == 1 && recorder_ != nullptr && recorder_->heard();
    return many ? kMany : static_cast<std::size_t>(threads_);
  }

  /// Loops whose result all ranks need may be divided among them: see collect_together().
  void divide_among(Ranks* ranks) { ranks_ = ranks; }
  [[nodiscard]] Ranks* ranks() const { return ranks_; }

  /// For loops of its owner: see Stop::check().
  void check() const {
    if (stop_ != nullptr) stop_->check();
  }

  /// Of the time that a range of a loop takes, what this lives is not work: it waits for another.
  class Waiting {
   public:
    explicit Waiting(const Arena& arena) : recorder_(arena.recorder_) {
      if (recorder_ != nullptr) since_ = Recorder::Clock::now();
    }
    ~Waiting() {
      if (recorder_ != nullptr) add(Recorder::Clock::now() - since_);
    }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;

   private:
    static void add(Recorder::Clock::duration waited);
    const Recorder* recorder_;
    Recorder::Clock::time_point since_;
  };

  /// What is done from now on, until the result is destroyed, belongs to this phase.
  [[nodiscard]] Recorder::Scope phase(Phase phase) const { return {recorder_, phase}; }

  /// Calls body(begin, end, worker) for consecutive ranges of `grain` items, the last one perhaps
  /// shorter, that cover 0..count-1. `worker` < threads() is not shared by two ranges at the same
  /// time. An exception thrown by `body` is passed on once all ranges have ended.
  template <class Body>
  void for_ranges(std::size_t count, std::size_t grain, Body&& body) const {
    if (count == 0) return;
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
  struct Range {
    const Arena* arena;
    RangeFunction function;
    void* context;
    std::size_t count;
    std::size_t grain;
    /// Range k, timed when the loop is.
    void operator()(std::size_t k, int worker, Recorder::Loop* timing) const;
    [[nodiscard]] std::size_t ranges() const { return (count + grain - 1) / grain; }
  };
  void run(std::size_t count, std::size_t grain, RangeFunction function, void* context) const;
  static void run_here(const Range& range, int worker, Recorder::Loop* timing);
  void run_on_all(const Range& range, Recorder::Loop* timing) const;

  struct Backend;
  int threads_ = 1;
  Stop* stop_ = nullptr;
  Recorder* recorder_ = nullptr;
  Ranks* ranks_ = nullptr;
  std::unique_ptr<Backend> backend_;
};

/// What arenas are made of.
std::string thread_library();

}  // namespace ccvt
