#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/options.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/meeting_pairs.h"
#include "relax/site_state.h"
#include "relax/swap.h"
#include "schedule/schedule.h"

namespace ccvt {

/// What one pass did.
struct PassCount {
  bool full = true;
  bool stopped = false;  ///< Options::cancelled said so in the middle
  std::int64_t pairs = 0;
  std::int64_t swaps = 0;
  std::int64_t exchanged = 0;
  Index active_sites = 0;
};

/// Relaxes one level: passes over pairs of cells, each followed by the centroid update, in the two
/// stages of the pair cache [4.2, Program 4].
///
/// A full pass examines each pair that can have come to gain since the last full pass: at least one
/// of its cells has changed since, and its bounding spheres meet. A full pass without a swap
/// therefore means that no pair of sites can gain: the tessellation is stable.
template <class Scalar>
class Relaxer {
 public:
  /// `cells` holds the points; `sites` where the sites are. Makes no move yet: call update_all().
  Relaxer(const Metric& metric, const Options& options, const Arena& arena, Stop& stop,
          Cells<Scalar>& cells, SiteState& sites, double coordinate_bound);

  /// Moves every site to the centroid of its cell.
  void update_all();

  /// One pass and the centroid update after it. When `stop` ends the pass, the update is still
  /// made, and `stop` switched off.
  PassCount step();

  [[nodiscard]] bool stable() const { return stable_; }

  /// The pairs listed: all whose bounding spheres meet, and more. Empty when nearly all do.
  [[nodiscard]] std::vector<Pair> listed() const;

 private:
  struct Worker {
    PairSwapper<Scalar> swap;
    PassCount count;
    std::vector<Pair> swapped;
    Index streamed = 0;  ///< points of pairs since the last look whether to stop
  };

  void full_pass();
  void list_pairs();
  void cached_pass();
  void all_pairs_pass();
  void screened_pass();
  void run(const Schedule& schedule, bool full);
  [[nodiscard]] bool may_gain(Index i, Index j, bool full) const;
  void examine(Worker& worker, Index i, Index j);
  void pass(bool full);
  void forget_pairs();
  bool cancelled() { return stopped_ = stopped_ || stop_.requested(); }
  void update_changed(bool full);

  const Metric& metric_;
  const Options& options_;
  const Arena& arena_;
  Stop& stop_;
  Cells<Scalar>& cells_;
  SiteState& sites_;
  std::vector<Worker> workers_;

  MeetingPairs meeting_;
  Schedule schedule_;
  Schedule added_schedule_;  ///< of the pairs added to the list since schedule_ was made
  bool dense_ = false;       ///< (nearly) all spheres meet: a list would not pay

  int dense_passes_ = 0;

  std::vector<std::uint8_t> changed_;  ///< in this pass
  std::vector<std::uint8_t> touched_;  ///< since the last full pass began
  std::vector<std::uint8_t> touched_tile_;
  std::vector<Pair> cache_;  ///< pairs that swapped in the last pass
  int cached_passes_ = 0;    ///< since the last full pass
  bool stable_ = false;
  bool stopped_ = false;
};

extern template class Relaxer<float>;
extern template class Relaxer<double>;

}  // namespace ccvt
