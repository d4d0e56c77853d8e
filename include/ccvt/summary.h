#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "ccvt/export.h"
#include "ccvt/types.h"

namespace ccvt {

/// How a run ended.
enum class Termination {
  /// Not ended yet.
  running,
  /// A full pass over every pair whose bounding spheres meet made no swap, and every site is the
  /// centroid of its cell: no exchange of points between any two sites lowers the energy.
  stable,
  /// As Until::blue_noise says, with many points a site.
  blue_noise,
  /// (E_before - E_after) < Options::energy_tolerance * E_before on the finest level.
  energy_tolerance,
  /// Options::max_iterations passes were made.
  iteration_limit,
  /// The seconds of a `time_limit` had passed.
  time_limit,
  /// Options::on_iteration returned false, Options::cancelled true, or Solver::cancel() was called.
  cancelled,
};

/// The words of the enumerators: "stable", "blue_noise", …
CCVT_EXPORT const char* to_string(Termination termination);

/// One iteration: a pass over a schedule of pairs, and the centroid update after it.
struct IterationRecord {
  int iteration = 0;           ///< from 1
  int level = 0;               ///< 0 is the coarsest
  int levels = 1;              ///< how many there are
  std::int64_t points = 0;     ///< points that take part on this level
  bool full = true;            ///< a full pass, not one over cached pairs
  std::int64_t pairs = 0;      ///< pairs examined
  std::int64_t swaps = 0;      ///< pairs that exchanged points
  std::int64_t exchanged = 0;  ///< points that changed owner
  Index active_sites = 0;      ///< sites whose cell changed
  double energy = 0;           ///< after the centroid update; falls within a level, up to rounding
  double seconds = 0;          ///< since the start of the run
  /// Of the run, in [0, 1]; never falls; 1 when stable or blue_noise. Of lloyd() and the training
  /// of a codebook an estimate, from how many points still change their owner.
  double progress = 0;
};

/// What part of a run took how long. Phases: initial "sites" and their order; "levels", which
/// points join on which; "nearest" sites of points; how they "join" cells; the "graph" of
/// neighbouring sites, the "potential" on it, and the "flow" down it of points where cells are too
/// full; "lists" of the pairs of sites that meet, and their "schedule"; "swap" of points between
/// the cells of a pair; "update" of the sites; "descent" of the energy by steps of all sites; what
/// it takes to "mend" cells that are torn between clouds of points; and "other".
struct PhaseRecord {
  std::string name;         ///< as above
  double seconds = 0;       ///< on the clock
  double work_seconds = 0;  ///< of these, work in parallel loops: of all threads together
  std::int64_t loops = 0;   ///< parallel loops, one after the other
  std::int64_t tasks = 0;   ///< in these
};

/// A parallel loop: its tasks ran at the same time as far as there were threads. Exchanges by
/// several threads have a task a thread, whose seconds are without what it waited for others.
struct LoopRecord {
  const char* phase = "";  ///< as in PhaseRecord
  double begin = 0;        ///< seconds since the start of the run
  double end = 0;
  std::span<const float> tasks;  ///< seconds that each took, in their order; valid during the call
};

/// What has become of a checkpoint, see Options::checkpoint.
struct CheckpointRecord {
  enum class Event {
    continued,  ///< the run has been read from the file
    saved,
    failed,  ///< not saved, but for the first time, or once it had been: the run goes on
  };
  Event event = Event::saved;
  int iteration = 0;    ///< the last one that it holds
  double seconds = 0;   ///< that reading or writing it took
  std::string failure;  ///< the reason
};

/// What happened in a run. Energies are sums of squared distances in the units of the points.
struct CCVT_EXPORT Summary {
  Termination termination = Termination::running;
  int dimension = 0;
  std::int64_t points = 0;
  Index sites = 0;
  int threads_given = 0;
  int threads_used = 0;
  std::uint64_t seed = 0;
  std::string initialization_used;  ///< "balanced", "coherent", "random" or "owners"
  int levels = 1;

  int iterations = 0;
  std::int64_t pairs = 0;      ///< pairs examined in all passes
  std::int64_t swaps = 0;      ///< of which exchanged points
  std::int64_t exchanged = 0;  ///< points that changed owner by swaps
  double initial_energy = 0;   ///< when all points have joined
  double energy = 0;
  /// energy * n^(2/D) / (m * |domain|^(2/D)); 0, and no figure, when the domain has no volume, or
  /// so little that this is beyond the range of double.
  double normalized_energy = 0;
  /// How many of the dimensions hold normals in place of coordinates. Energies then are of both
  /// together, and have no normalized figure.
  int normal_dimensions = 0;
  /// See ccvt::capacity_error(): not zero when capacities are meant to differ.
  double capacity_error = 0;

  double seconds_total = 0;
  double seconds_initialization = 0;
  double seconds_relaxation = 0;
  /// Where the time went, of the whole run; known when it has ended.
  std::vector<PhaseRecord> phases;
  std::vector<IterationRecord> iterations_log;
  /// What makes the result worse than it need be, a sentence each; known when the run has ended:
  /// coordinates so large that their type cannot tell points apart; an end before all had joined;
  /// a checkpoint that could not be written, where there is no Options::on_checkpoint.
  std::vector<std::string> warnings;

  /// False when normalized_energy is 0 for want of a volume, or as normals are dimensions.
  [[nodiscard]] bool has_normalized_energy() const;
  /// One line: how it ended, iterations, energy, seconds.
  [[nodiscard]] std::string brief() const;
  /// All of it, as a table.
  [[nodiscard]] std::string full() const;
};

}  // namespace ccvt
