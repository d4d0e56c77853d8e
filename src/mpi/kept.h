#pragma once

#include <mpi.h>

#include <chrono>
#include <optional>

#include "ccvt/options.h"
#include "cli/kept_run.h"
#include "cli/progress.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "session.h"

namespace ccvt::mpi {

/// The run of a command, kept as --checkpoint says: the first rank has the directory, and reads and
/// writes what is in it.
class Kept {
 public:
  /// On all ranks. `arguments` must outlive it.
  Kept(const Session& session, const cli::CommonArguments& arguments)
      : session_(session), arguments_(arguments) {
    session_.together([&] { run_.emplace(arguments_, session_.is_first(), kTimeToNotice); });
  }

  /// Gives work(options), which runs a Solver. mpirun passes Ctrl-C on as SIGTERM, and does not
  /// wait for long: a run that is kept is then kept once more, and its result is not waited for.
  /// Throws Failure then.
  template <class Work>
  auto solve(const Options& defaults, Index sites, const Work& work) const {
    std::optional<cli::EndsAsked> ends;
    if (run_->keeps()) ends.emplace();
    cli::Progress progress(arguments_.quiet, arguments_.time_limit);
    Options options =
        run_->options(cli::make_options(arguments_, defaults, sites, progress), progress);
    options.on_checkpoint = [this, tell = options.on_checkpoint](const CheckpointRecord& record) {
      tell(record);
      end_if_asked();
    };
    auto result = work(options);
    end_if_asked();
    session_.share_interrupt();
    return result;
  }

  /// On the first rank, when all outputs are there: see cli::KeptRun.
  void end(const Summary& summary) const { run_->end(summary); }

 private:
  /// Ranks whose mpirun was killed, and which hold the directory, end within so long.
  static constexpr std::chrono::milliseconds kTimeToNotice{5'000};

  /// On all ranks, when one has been told to end.
  void end_if_asked() const {
    int signal = cli::EndsAsked::signal();
    MPI_Allreduce(MPI_IN_PLACE, &signal, 1, MPI_INT, MPI_MAX, MPI_COMM_WORLD);
    if (signal == 0) return;
    throw Failure{"ended by a signal; the same command, or one with other limits, goes on from " +
                      arguments_.checkpoint.string(),
                  128 + signal};
  }

  const Session& session_;
  const cli::CommonArguments& arguments_;
  std::optional<cli::KeptRun> run_;
};

}  // namespace ccvt::mpi
