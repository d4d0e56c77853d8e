#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>

#include "ccvt/export.h"
#include "ccvt/summary.h"

namespace ccvt {

/// How points get their first owners. All keep the capacities exactly.
enum class Initialization {
  /// Balanced up to 8 dimensions, coherent beyond.
  automatic,
  /// Every point takes its nearest site; the excess then flows between neighbouring sites until
  /// capacities are exact. Leaves no strays; the fastest start in few dimensions.
  balanced,
  /// Every point, in a seeded random order, takes the nearest site that still has room [Program 6].
  coherent,
  /// Random owners [Program 1].
  random,
};

/// How a swap picks the points that two cells exchange. All reach the same energy.
enum class SwapMethod {
  /// Selection of the cut by its rank, in linear time [4.1, Program 3].
  median,
  /// Two heaps, popped while an exchange still gains [Program 1].
  heap,
  /// A full sort of both cells: the slow, obvious version, kept as an oracle.
  sort,
};

/// Which points of a pair take part in a swap.
enum class PointPruning {
  /// All of both cells.
  none,
  /// Those within the distance of [5.2, eq. 8 and 9] of the other site.
  distance,
  /// Those whose key lies beyond the other cell's extreme key: the exact set that can move.
  extremes,
};

/// Which pairs of sites are examined in a full pass.
enum class PairSelection {
  /// All n(n-1)/2 of them [Program 1], in round-robin batches [Program 5].
  all,
  /// Those whose bounding spheres meet [5.1, eq. 7] and of which at least one cell has changed
  /// since the last full pass. In high dimension, where all spheres meet, those that one blocked
  /// matrix product shows to gain; up to 4096 sites, what it finds is kept, n^2 coordinates, so
  /// that later passes multiply only what may have come to gain.
  meeting,
};

/// Where a run ends. One and the same with few points a site: see Options::descent_points.
enum class Until {
  /// No exchange of points between any two sites lowers the energy, and every site is the centroid
  /// of its cell: the lowest energy. The more points a site, the lower, and the more regular: from
  /// some thousands on sites are a lattice with faults.
  stable,
  /// Sites stay about as irregular as with a thousand points a site, and have less noise at low
  /// frequencies: a level of many points a site ends as soon as its points have their owners. Then
  /// cells are those of a power diagram, and every site is the centroid of its cell,
  /// but an exchange of points may still lower the energy.
  blue_noise,
};

/// What to do and how. The defaults are the fastest combination that keeps a clean spectrum; see
/// benchmarks/README.md for the measurements. Every field may be set alone.
struct CCVT_EXPORT Options {
  /// Threads to use; 0: one per processor. Any number gives identical bits.
  int threads = 0;
  /// Fixes every random choice: initial sites, subsets of levels, visiting orders.
  std::uint64_t seed = 0;

  /// Stops after this many iterations (passes), those of coarse levels included. At least 0; points
  /// of levels not reached then join by initialization alone.
  int max_iterations = 1'000'000;
  /// Stops on the finest level when an iteration lowers the energy by less than this share of it.
  /// In [0, 1); 0: run until stable.
  double energy_tolerance = 0;
  /// Seconds after which the run ends as if it were cancelled, see `cancelled`: from when the
  /// Solver is made, with what its caller does between steps. Not negative; 0: no limit. What a run
  /// that ends so has reached is not the same each time.
  double time_limit = 0;
  Until until = Until::stable;

  /// How points get their first owners, on each level.
  Initialization initialization = Initialization::automatic;

  /// Multi-level optimisation [5.2]: relax a random subset first, spread evenly, of `level_points`
  /// points a site or more (but less than `level_factor` times that), then `level_factor` times as
  /// many, and so on. Ends lower and more even than one level.
  ///
  /// Between clouds of points, exchanges of pairs can end with cells that are torn: their points
  /// lie in several clouds. Where that costs a hundredth of the energy, at the end of a level, and
  /// so of a run that is stable, points of up to 512 sites around such cells, and 65536 points, are
  /// assigned at the least cost for all of these sites at once, and the sites move, in turn, until
  /// that gains little: with `pairs` that meet, and unless half of the sites are fixed.
  bool multilevel = true;
  int level_points = 8;
  int level_factor = 4;

  /// With so many points a site or more, in the mean, a level is not lowered by exchanges of pairs,
  /// which creep the more the finer the points are. Until stable, and if the finest level has four
  /// times as many: by quasi-Newton steps of all sites at once, on power diagrams [Liu et al. 2009;
  /// de Goes et al. 2012]; pairs settle the rest on the finest, and where that takes hundreds of
  /// passes, such steps come again. If it has less, but is not the only one, by one such step
  /// there, before pairs. Until blue_noise: the points of such a level, beyond the first level,
  /// change their owners to those of one power diagram. In both cases with `pairs` that meet, and
  /// where cells have no more than 64 neighbours in the mean and 512 at most, and are small beside
  /// a torus; else by pairs. At least 0; 0: never.
  int descent_points = 512;

  SwapMethod swap = SwapMethod::median;
  PointPruning point_pruning = PointPruning::extremes;
  /// Leave a pair alone when its cells are already separated [5.2]. PointPruning::extremes contains
  /// this test, so it matters with the other two only.
  bool median_cut_pruning = true;

  PairSelection pairs = PairSelection::meeting;
  /// Two-stage pair cache [4.2, Program 4]: after each full pass, at most this many passes over
  /// the pairs that swapped in the pass before. 0: full passes only.
  int cached_passes = 0;

  /// Sites a tile. Pairs inside one tile, or between two, make one task: a tile stays in cache and
  /// tasks of a batch share no site. 1: every pair a task of its own, as in the paper [4.3].
  int tile_sites = 64;

  /// Called after each iteration from the thread that runs the solver; false cancels.
  std::function<bool(const IterationRecord&)> on_iteration = {};
  /// Asked several times a second, from the thread that runs the solver; true ends the run there,
  /// with the points owned as they then are. Points that have not joined yet then join as always if
  /// that takes no longer than a third of a second. Else they are dealt out to sites with room,
  /// near ones where that is easily told, and the sites stay where the last level left them:
  /// capacities are exact, but sites are not the centroids of their cells, and the energy says so.
  std::function<bool()> cancelled = {};

  /// Called after each parallel loop from the thread that runs the solver, for measurements: how
  /// evenly the work of a problem can be shared. What it throws is passed on at the end of the
  /// pass, or of the run.
  std::function<void(const LoopRecord&)> on_loop = {};

  /// A file that the run is kept in, so that it outlives its process; empty: none. If it is there,
  /// a Solver continues from it, to the bits of a run that was never interrupted, with any number
  /// of threads and ranks; one of other points, settings or options than these, limits but for, or
  /// of another version, or a damaged one is refused: InvalidInput says why. The run is saved
  /// there, as Solver::save() does, at once (IoError), then between two iterations every
  /// `checkpoint_seconds`, where a failure does not end it, and when it is cut short: by a limit,
  /// or cancelled. For that it may first complete the iteration, if it takes no longer than ten
  /// seconds; else the file stays as it last was. It stays at the end, too: whoever has the result
  /// removes it. Of several ranks the first has the file, and a failure is one of all; they are not
  /// given ten seconds, but end after the iteration. For what runs one Solver: tessellate(),
  /// stipple(), sample_volume(), and tessellate_masses(), which keeps the way to the unit points'
  /// end and repeats what follows; the others throw InvalidInput.
  std::filesystem::path checkpoint = {};
  /// Seconds from one checkpoint to the next, at the least. Not negative; 0: after each iteration.
  double checkpoint_seconds = 600;
  /// Called when the run has been read or saved, or could not be, from the thread that runs the
  /// solver.
  std::function<void(const CheckpointRecord&)> on_checkpoint = {};

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;

  /// The defaults until blue_noise: for sites that are to be samples, irregular, rather than the
  /// best partition of the points.
  static Options samples();
  /// The method of Balzer et al. 2009 [Program 1]: random start, all pairs, heap swap, one level.
  static Options balzer2009();
  /// The method of the paper's section 4: median swap, two-stage cache, batches of single pairs.
  static Options section4();
  /// Section 4 with all optimisations of section 5: the last row of Table 1.
  static Options fast_ccvt();
};

}  // namespace ccvt
