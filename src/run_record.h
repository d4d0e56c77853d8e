#pragma once

#include <exception>
#include <optional>
#include <utility>

#include "ccvt/options.h"
#include "ccvt/problem.h"
#include "ccvt/summary.h"
#include "parallel/bytes.h"
#include "parallel/recorder.h"
#include "relax/relaxer.h"
#include "stopwatch.h"

namespace ccvt {

/// Keeps the summary of a run of the solver.
class RunRecord {
 public:
  explicit RunRecord(const Options& options);

  [[nodiscard]] Summary& summary() { return summary_; }
  [[nodiscard]] const Summary& summary() const { return summary_; }
  /// Charges phases.
  [[nodiscard]] Recorder& clock() { return clock_; }

  [[nodiscard]] bool ended() const { return summary_.termination != Termination::running; }
  [[nodiscard]] int iterations() const { return summary_.iterations; }
  [[nodiscard]] double energy() const { return summary_.energy; }

  /// What is done until the result is destroyed counts as that, and in phases; once, where these
  /// are nested.
  class Timed {
   public:
    Timed(RunRecord& record, double& seconds) : record_(record) {
      if (record.timed_) return;
      record.timed_ = true;
      total_.emplace(record.summary_.seconds_total);
      part_.emplace(seconds);
      record.clock_.go_on();
    }
    ~Timed() {
      if (!total_) return;
      record_.clock_.rest();
      record_.timed_ = false;
    }
    Timed(const Timed&) = delete;
    Timed& operator=(const Timed&) = delete;

   private:
    RunRecord& record_;
    std::optional<Stopwatch> total_;
    std::optional<Stopwatch> part_;
  };
  [[nodiscard]] Timed initializing() { return {*this, summary_.seconds_initialization}; }
  [[nodiscard]] Timed relaxing() { return {*this, summary_.seconds_relaxation}; }

  /// A level begins with this energy; the finest one with the run's initial energy.
  void begin(double energy, bool finest);
  /// A pass has been made. What Options::on_iteration says of it.
  bool add(const PassCount& pass, int level, std::int64_t points, double energy, double progress,
           const Options& options);
  /// Of a run that has not ended, what has been recorded so far; what hangs on the clock comes
  /// last.
  void save(ByteWriter& out);
  /// The last of what `in` holds. Throws Damaged, and is then as it was.
  void load(ByteReader& in);
  template <class Scalar>
  void end(Termination termination, const Problem<Scalar>& problem, const Box& box);

 private:
  void rethrow();

  Summary summary_;
  Recorder clock_;
  std::exception_ptr
      failure_;  ///< of Options::on_loop, until the pass or the run has been recorded
  bool timed_ = false;
};

}  // namespace ccvt
