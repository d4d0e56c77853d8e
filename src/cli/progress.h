#pragma once

#include <chrono>
#include <cstddef>
#include <string>

#include "ccvt/summary.h"

namespace ccvt::cli {

/// One line on the terminal behind stderr, redrawn in place; nothing when stderr is no terminal, or
/// a dumb one (TERM). Without colours and other escape codes.
class Progress {
 public:
  /// `time_limit`: when the run is to end, in seconds from its start; 0: at no such time.
  Progress(bool quiet, double time_limit);
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Clears the line.
  ~Progress();

  /// Redraws at most 20 times a second.
  void show(const IterationRecord& record, Index sites);
  /// Makes room for a line of something else.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;

  void redraw(const std::string& text);

  bool live_;
  double time_limit_;
  std::size_t drawn_ = 0;  ///< letters of the line as it stands
  Clock::time_point last_;
};

}  // namespace ccvt::cli
