#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <utility>

#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "cli/arguments.h"
#include "cli/progress.h"

namespace ccvt::cli {

/// The file that --checkpoint keeps the run in; none without.
std::filesystem::path checkpoint_file(const CommonArguments& arguments);

/// The directory of --checkpoint, if there is one: held by one process at a time, for as long as
/// this lives. In it is one file, which the run is kept in.
class KeptRun {
 public:
  /// Makes the directory, and removes what a process that was killed has left of a checkpoint that
  /// it was writing. Throws InvalidInput where that cannot be, or another process has the
  /// directory for longer than `patience`. Of several processes that make one run, one `holds` the
  /// directory, and the others leave it alone.
  explicit KeptRun(const CommonArguments& arguments, bool holds = true,
                   std::chrono::milliseconds patience = {});
  KeptRun(const KeptRun&) = delete;
  KeptRun& operator=(const KeptRun&) = delete;
  ~KeptRun();

  [[nodiscard]] bool keeps() const { return !file_.empty(); }

  /// The options, and with them how the run is kept. Both `progress` and this must outlive them.
  [[nodiscard]] Options options(Options options, Progress& progress) const;

  /// blame() of cli/run.h, but for what is wrong with the checkpoint.
  template <class Work>
  decltype(auto) blame(const std::filesystem::path& path, Work&& work) const {
    try {
      return std::forward<Work>(work)();
    } catch (const InvalidInput& error) {
      const std::string message = error.what();
      if (!file_.empty() && message.rfind(file_.string(), 0) == 0) throw;
      throw InvalidInput(path.string() + ": " + message);
    }
  }

  /// When all outputs are there: removes the file of a run that is complete, and says where one
  /// goes on that is not.
  void end(const Summary& summary) const;

 private:
  void hold(std::chrono::milliseconds patience);
  void remove_left_over() const;
  void tell(const CheckpointRecord& record, Progress& progress) const;

  std::filesystem::path directory_;
  std::filesystem::path file_;  ///< empty: nothing is kept
  double seconds_;
  bool quiet_;
  int descriptor_ = -1;
};

}  // namespace ccvt::cli
