#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/options.h"
#include "ccvt/problem.h"
#include "ccvt/summary.h"
#include "checkpoint/checkpoint_file.h"
#include "checkpoint/tile_parts.h"
#include "descent/descent.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/stop.h"
#include "relax/cells.h"
#include "relax/filling.h"
#include "relax/levels.h"
#include "relax/own_points.h"
#include "relax/relaxer.h"
#include "run_identity.h"
#include "run_record.h"
#include "torn/windows.h"

namespace ccvt {

/// Beyond so many dimensions the automatic start is the coherent one.
constexpr int kBalancedDimensions = 8;
/// Pairs end most descended levels within some hundred passes; now and then they creep for tens of
/// thousands, on a slope that a descent took for its end: 64 sites of 262144 points, 8 seeds, took
/// 10.7 s in the mean and 73 at most, 2.7 and 8.9 with another descent after so many passes. Each
/// counts as the share of sites that it changes: the last ones, over few sites, should not make a
/// run descend that ends soon (256 sites of 65536 points took twice as long).
constexpr double kPatience = 256;
/// Of one level.
constexpr int kMostDescents = 8;

/// What a Solver does, from the first sites to its end.
template <class Scalar>
struct Run {
  Run(Problem<Scalar> given_problem, Options given_options);

  static constexpr std::size_t kPointsPerGrain = std::size_t{1} << 16;

  bool step();
  bool end(Termination termination);
  /// In the caller's order.
  [[nodiscard]] Columns<Scalar> site_columns() const;
  /// Of the points of this rank.
  [[nodiscard]] std::vector<Index> owners() const;
  /// See Solver.
  void save(const std::filesystem::path& file);
  void load(const std::filesystem::path& file);
  /// Ends a run that may be continued from Options::checkpoint, if there is one. False.
  bool end_for_now(Termination termination);

  bool begin_or_continue();
  void place_sites();
  [[nodiscard]] OwnPoints<Scalar> own_points() const {
    return {problem.points(), problem.first_own_point()};
  }
  [[nodiscard]] double energy_of_sites() {
    const auto timed = record.relaxing();
    const Stop::Pause pause(stop);
    return total_energy(state.sites, arena);
  }
  [[nodiscard]] bool on_finest_level() const { return level + 1 == levels.size(); }
  PassCount pass();
  bool go_on_from(double energy_before, double energy);

  // Of levels, in run_levels.cpp.
  void divide_points();
  [[nodiscard]] Cells<Scalar> empty_cells(const std::vector<Index>& sizes) const;
  void take_owners();
  void enter_level(std::size_t next);
  [[nodiscard]] std::optional<Stop::Pause> pause_for(std::int64_t points);
  void join(const JoiningPoints& joining, std::span<const Pair> near, Filling<Scalar>& filling);
  void deal(const Cells<Scalar>& owned, std::span<const Index> filled);
  [[nodiscard]] std::unique_ptr<Relaxer<Scalar>> make_relaxer(std::span<const Index> sizes);
  void begin_level();
  [[nodiscard]] std::optional<Depth> descends() const;
  [[nodiscard]] double least_gain(int before) const;
  void begin_descent(Depth depth, double energy);
  void leave_to_pairs(double energy);
  [[nodiscard]] bool pairs_creep() const;
  void descend_again(double energy);

  // In run_torn.cpp.
  [[nodiscard]] WindowLimits torn_windows() const;
  bool mend_torn_cells();

  // Of checkpoints, in run_checkpoint.cpp.
  [[nodiscard]] bool is_kept() const { return !options.checkpoint.empty(); }
  RunIdentity identity(const Arena& apart);
  /// Of what the lists of pairs of all ranks were extended by.
  struct AddedPairs {
    Buffer<Pair> relaxed;
    Buffer<Pair> descended;
  };
  [[nodiscard]] ByteWriter save_common(const RunIdentity& own, const AddedPairs& added);
  [[nodiscard]] std::vector<std::byte> save_tiles(const TilePart& part, const Arena& apart) const;
  struct Head {
    std::vector<std::byte> common;
    std::uint64_t tiles;  ///< bytes
  };
  [[nodiscard]] Head shared_head(const std::optional<CheckpointReader>& in) const;
  void load_from(const std::filesystem::path& file, std::optional<CheckpointReader>& in,
                 const Head& head);
  void load_tiles(const std::filesystem::path& file, const TilePart& part,
                  std::span<const std::byte> bytes, const Arena& apart, Cells<Scalar>& cells,
                  Relaxer<Scalar>& patches) const;
  [[nodiscard]] bool continues() const;
  void take_kept();
  void begin_keeping();
  void keep();
  void keep_if_due();
  void tell(CheckpointRecord::Event event, double seconds, const std::string& failure = {});
  [[nodiscard]] double progress(const PassCount& done) const;
  /// Of `stop` and `stop_of_ranks` the one that is asking Options::cancelled, or nullptr.
  Stop* asking() {
    if (stop.asks()) return &stop;
    return stop_of_ranks.asks() ? &stop_of_ranks : nullptr;
  }

  // Of several ranks, in run_ranks.cpp.
  [[nodiscard]] Ranks* ranks() const { return problem.ranks(); }
  void require_for_ranks() const;
  void require_full_cells() const;
  bool cancelled_together(bool own);
  [[nodiscard]] std::vector<Index> owners_at_home() const;
  void fetch_coordinates(const Arena& apart, Cells<Scalar>& cells) const;

  Problem<Scalar> problem;
  bool warm;  ///< the problem has owners
  Options options;
  Stop stop;
  Stop stop_of_ranks;
  bool late = false;  ///< it was the time that ended ranks
  RunRecord record;
  Arena arena;
  Domain domain;  ///< in which distances are measured
  Metric metric;
  Box box;                      ///< of the points
  Box around;                   ///< where sites are looked for
  double coordinate_bound = 0;  ///< on the absolute values of those of points and sites

  /// The solver numbers sites by where they are: site_of[k] is the caller's number of site k.
  std::vector<SiteNumber> site_of;
  std::vector<Level> levels;
  std::size_t level = 0;
  LevelState<Scalar> state;
  std::unique_ptr<Relaxer<Scalar>> relaxer;
  std::unique_ptr<Descent<Scalar>> descent;  ///< while it goes on
  /// How this level is lowered: the finest by descents and passes over pairs in turn.
  struct Turns {
    int descents = 0;   ///< that have begun
    double passes = 0;  ///< over all pairs, since the last of them; see kPatience
    double before = 0;  ///< the energy where it began
    double after = 0;   ///< and where the last that is over ended
    double excess = 0;  ///< of torn cells, when they were last mended
  } turns;
  double patience = kPatience;  ///< passes before sites descend again; see there
  std::vector<double> weights;  ///< of sites, for descents
  /// Of a run that was cancelled, when there was no time for more: the owners, by deal_rest().
  std::vector<SiteNumber> dealt;

  std::optional<PointDigests> point_digests;  ///< once they are asked for
  std::chrono::steady_clock::time_point kept_at;
  bool keeping_fails = false;
};

extern template struct Run<float>;
extern template struct Run<double>;

}  // namespace ccvt
