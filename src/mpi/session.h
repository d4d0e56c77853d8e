#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <new>
#include <string>
#include <utility>

#include "ccvt/io.h"
#include "ccvt/mpi.h"
#include "ccvt/options.h"
#include "ccvt/types.h"
#include "cli/arguments.h"
#include "cli/memory.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "parallel/together.h"

namespace ccvt::mpi {

/// What ends all ranks: on each of them the same.
struct Failure {
  std::string message;
  int status;
};

/// What ccvt-mpi knows of its ranks.
class Session {
 public:
  explicit Session(MpiRanks& ranks) : ranks_(ranks), ranks_here_(count_here()) {}

  [[nodiscard]] MpiRanks& ranks() const { return ranks_; }
  [[nodiscard]] bool is_first() const { return ranks_.rank() == 0; }

  /// Of `count` things, this rank's: begin.. to end - 1.
  struct Share {
    std::int64_t begin;
    std::int64_t end;
    [[nodiscard]] std::int64_t size() const { return end - begin; }
    /// How to read these of the rows of a file.
    [[nodiscard]] ReadOptions of(ReadOptions options) const {
      options.first_row = static_cast<std::uint64_t>(begin);
      options.end_row = static_cast<std::uint64_t>(end);
      return options;
    }
  };
  [[nodiscard]] Share share(std::int64_t count) const {
    const auto place = [&](std::int64_t rank) { return count * rank / ranks_.count(); };
    return {place(ranks_.rank()), place(ranks_.rank() + 1)};
  }

  /// Arguments for this rank: as many threads as its share of the processors, unless the user says
  /// how many, and what is printed only from the first one.
  template <class Arguments>
  [[nodiscard]] Arguments own(Arguments arguments) const {
    if (arguments.threads == 0) arguments.threads = own_threads();
    if (!is_first()) arguments.quiet = true;
    return arguments;
  }

  /// Points, or what else a rank has so many of, of all ranks on its machine, if they have as many:
  /// for what is said of memory.
  [[nodiscard]] std::uint64_t on_machine(std::int64_t own) const {
    return static_cast<std::uint64_t>(own) * static_cast<std::uint64_t>(ranks_here_);
  }

  /// As cli::check_memory(), where all ranks on this machine tessellate as many points as this one,
  /// in cells of `cell` points, and hold as many other bytes.
  void check_memory(const std::string& what, std::int64_t own, int dimension,
                    std::size_t scalar_bytes, std::int64_t cell,
                    std::int64_t other_bytes = 0) const {
    // A cell's points are put into their order when they have come: see Filling::sort_added().
    constexpr std::int64_t kSorted = 40;
    const auto coordinates = static_cast<std::int64_t>(scalar_bytes) * dimension;
    other_bytes += std::min(own, cell) * (kSorted + coordinates);
    cli::check_memory(what, on_machine(own), dimension, scalar_bytes, on_machine(other_bytes),
                      processes_here());
  }
  /// Throws InvalidInput where --sites and --points-per-site make more points than all ranks
  /// together may have.
  static void check_count(Index sites, Index points_per_site);
  /// Ranks on this machine.
  [[nodiscard]] std::uint64_t processes_here() const {
    return static_cast<std::uint64_t>(ranks_here_);
  }

  /// Calls `work` on each rank for itself. What it throws on one of them ends all, as a Failure.
  template <class Work>
  void together(const Work& work) const;

  /// On all ranks, when a run has ended: what one of them was told by Ctrl-C, all were.
  void share_interrupt() const {
    if (any(&ranks_, cli::interrupted())) cli::interrupt_too();
  }

  /// The figures of all ranks.
  [[nodiscard]] cli::RankFigures figures() const;

 private:
  [[nodiscard]] static int count_here();
  [[nodiscard]] int own_threads() const;

  MpiRanks& ranks_;
  int ranks_here_;  ///< on this rank's machine
};

template <class Work>
void Session::together(const Work& work) const {
  try {
    agree(&ranks_, work);
  } catch (const InvalidInput& error) {
    throw Failure{error.what(), 2};
  } catch (const std::bad_alloc&) {
    throw Failure{"out of memory", 1};
  } catch (const std::exception& error) {
    throw Failure{error.what(), 1};
  }
}

}  // namespace ccvt::mpi
