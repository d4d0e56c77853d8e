#include <mpi.h>

#include <exception>
#include <iostream>
#include <new>
#include <span>
#include <string>

#include "ccvt/io.h"
#include "ccvt/metrics.h"
#include "ccvt/mpi.h"
#include "ccvt/version.h"
#include "cli/command_line.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/standard_streams.h"
#include "cli/streams.h"
#include "command_line.h"
#include "commands.h"
#include "help.h"

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace {

using ccvt::mpi::Session;

int run(const Session& session, int argc, char** argv) {
  ccvt::mpi::CommandLine line;
  const ccvt::cli::Commands commands = {
      {line.sample.command, [&] { return run_sample(session, line.sample.arguments); }},
      {line.tessellate.command, [&] { return run_tessellate(session, line.tessellate.arguments); }},
      {line.quantize.command, [&] { return run_quantize(session, line.quantize.arguments); }},
      {line.encode.command, [&] { return run_encode(session, line.encode.arguments); }},
      {line.volume.command, [&] { return run_volume(session, line.volume.arguments); }},
  };
  if (argc > 1) ccvt::mpi::require_command(line.app, argv[1]);
  return ccvt::cli::parse_and_run(line.app, commands, argc, argv, [&](const std::string& text) {
    if (session.is_first()) ccvt::cli::print(text);
  });
}

/// Throws Failure on all ranks unless they were started alike, but for --threads.
void require_alike(const Session& session, int argc, char** argv) {
  std::string own = CCVT_VERSION;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument == "--threads") ++k;
    if (argument.rfind("--threads", 0) != 0) own += '\0' + argument;
  }
  const auto all = session.ranks().gather(std::as_bytes(std::span(own)));
  for (std::size_t r = 1; r < all.size(); ++r) {
    if (all[r] == all[0]) continue;
    throw ccvt::mpi::Failure{"rank " + std::to_string(r) +
                                 " was started with other arguments than rank 0, or is of another "
                                 "version; all need the same, but for --threads",
                             2};
  }
}

void tell(const std::string& message) {
  std::cerr << ccvt::cli::one_line("ccvt-mpi: error: " + message);
}

/// Of what goes wrong on all ranks only the first one speaks; where it is this one alone, it ends
/// the others.
int run_all(const Session& session, int argc, char** argv) {
  const auto report = [&](const std::string& message, int status) {
    if (session.is_first()) tell(message);
    return status;
  };
  const auto end_all = [](const std::string& message, int status) {
    tell(message);
    ccvt::remove_unfinished_files();
    MPI_Abort(MPI_COMM_WORLD, status);
    return status;
  };
  try {
    require_alike(session, argc, argv);
    return run(session, argc, argv);
  } catch (const ccvt::mpi::Failure& failure) {
    return report(failure.message, failure.status);
  } catch (const ccvt::InvalidInput& error) {
    return report(error.what(), 2);
  } catch (const ccvt::IoError& error) {
    return report(error.what(), 1);
  } catch (const ccvt::MpiFailure& failure) {
    return end_all("rank " + std::to_string(session.ranks().rank()) + ": " + failure.message, 1);
  } catch (const std::bad_alloc&) {
    return end_all("rank " + std::to_string(session.ranks().rank()) + " is out of memory", 1);
  } catch (const std::exception& error) {
    return end_all(error.what(), 1);
  }
}

}  // namespace

int main(int argc, char** argv) {
#ifdef __GLIBC__
  // What is freed goes back to the system at once: messages come in many sizes, between which the
  // heap would be left with holes.
  constexpr int kLarge = 1 << 20;
  mallopt(M_MMAP_THRESHOLD, kLarge);
  mallopt(M_TRIM_THRESHOLD, kLarge);
#endif
  int provided = MPI_THREAD_SINGLE;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &provided);
  int status = 1;
  {
    ccvt::MpiRanks ranks(MPI_COMM_WORLD);
    ccvt::cli::fill_closed_streams();
    ccvt::cli::handle_signals();
    ccvt::cli::refuse_streams("ccvt-mpi");
    status = run_all(Session(ranks), argc, argv);
  }
  MPI_Finalize();
  return status;
}
