#pragma once

#include <chrono>

#include "ccvt/summary.h"

namespace ccvt::cli {

/// One line on the terminal behind stderr, redrawn in place; nothing when stderr is no terminal.
class Progress {
 public:
  explicit Progress(bool quiet);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Clears the line.
  ~Progress();

  /// Redraws at most 20 times a second.
  void show(const IterationRecord& record, Index sites);

 private:
  using Clock = std::chrono::steady_clock;

  bool live_;
  bool drawn_ = false;
  Clock::time_point last_;
};

}  // namespace ccvt::cli
