#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace ccvt {

/// What the solver does, for its summary.
enum class Phase {
  other,
  sites,      ///< initial sites, and their order
  levels,     ///< which points join on which level
  nearest,    ///< the nearest site of each point
  join,       ///< points into cells
  graph,      ///< of neighbouring sites
  potential,  ///< of the flow between them
  flow,       ///< of what sites have too much
  lists,      ///< of the pairs that meet
  schedule,   ///< of these pairs
  swap,       ///< of points between the cells of a pair
  update,     ///< of the sites
  descent,    ///< of the energy, all sites at once
  mend,       ///< cells that are torn
};
inline constexpr std::size_t kPhases = 14;
const char* name_of(Phase phase);

/// Where time goes: for each phase how long it took, how much of that was work in parallel loops,
/// and in how many tasks. An Arena carries it. One thread switches phases and starts loops; the
/// tasks of a loop are timed wherever they run.
class Recorder {
 public:
  using Clock = std::chrono::steady_clock;

  struct Share {
    double seconds = 0;
    double work_seconds = 0;  ///< in tasks, all workers together
    std::int64_t loops = 0;
    std::int64_t tasks = 0;
  };

  /// One parallel loop, as it was run.
  struct Loop {
    Phase phase = Phase::other;
    double begin = 0;  ///< seconds since the recorder was made
    double end = 0;
    std::vector<float> tasks;  ///< seconds of each, in their order
  };

  [[nodiscard]] const std::array<Share, kPhases>& shares() const { return shares_; }
  /// What an earlier part of the run has taken.
  void add(const std::array<Share, kPhases>& earlier);
  /// Charges the current phase with the time up to now.
  void charge() { enter(phase_); }
  /// Between these two no phase is charged with time.
  void rest() {
    charge();
    rests_ = true;
  }
  void go_on() {
    charge();
    rests_ = false;
  }

  /// Tells of each loop when it has ended. The listener must not throw, nor start loops.
  void listen(std::function<void(const Loop&)> listener) { listener_ = std::move(listener); }
  [[nodiscard]] bool heard() const { return static_cast<bool>(listener_); }

  /// Charges a phase until it is destroyed, and then the one before.
  class Scope {
   public:
    Scope(Recorder* recorder, Phase phase) : recorder_(recorder) {
      if (recorder_ != nullptr) before_ = recorder_->enter(phase);
    }
    ~Scope() {
      if (recorder_ != nullptr) recorder_->enter(before_);
    }
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Recorder* recorder_;
    Phase before_ = Phase::other;
  };

  /// For Arena: a loop of so many tasks begins; its task times go into the result; it has ended,
  /// and not by an exception.
  Loop& begin_loop(std::size_t tasks);
  void end_loop();

 private:
  friend class Scope;
  Phase enter(Phase phase);
  [[nodiscard]] double now() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

  Clock::time_point start_ = Clock::now();
  double since_ = 0;  ///< the current phase
  Phase phase_ = Phase::other;
  bool rests_ = false;
  std::array<Share, kPhases> shares_{};
  Loop loop_;
  std::function<void(const Loop&)> listener_;
};

}  // namespace ccvt
