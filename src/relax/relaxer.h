#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/options.h"
#include "geometry/metric.h"
#include "parallel/bytes.h"
#include "parallel/loops.h"
#include "relax/level_state.h"
#include "relax/loans.h"
#include "relax/pair_lists.h"
#include "relax/screen.h"
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
/// stages of the pair cache [4.2, Program 4]. Owns what is known of the pairs, and nothing else.
///
/// A full pass examines each pair that can have come to gain since the last full pass: at least one
/// of its cells has changed since, and its bounding spheres meet. A full pass without a swap
/// therefore means that no pair of sites can gain: the tessellation is stable.
template <class Scalar>
class Relaxer {
 public:
  /// `sizes`: how many points the cell of each site has.
  Relaxer(const Metric& metric, const Options& options, const Arena& arena, Stop& stop,
          std::span<const Index> sizes, double coordinate_bound);

  /// One pass [4.2], and the centroid update after it. When `stop` ends the pass, the update is
  /// still made, and `stop` switched off. `state` is the same, or in the same state, each time.
  PassCount step(LevelState<Scalar>& state);

  /// Between two passes: what is known of all pairs, and of the cell of a site, apart. `added`:
  /// added_pairs() of all ranks.
  void save(ByteWriter& out, std::span<const Pair> added) const;
  void load(ByteReader& in, const Tiling& tiling);
  void save_cell(ByteWriter& out, SiteNumber site, Index points) const {
    patches_.save(out, site, points);
  }
  [[nodiscard]] std::size_t cell_bytes(Index points) const { return patches_.bytes(points); }
  void load_cell(ByteReader& in, SiteNumber site, Index points) { patches_.load(in, site, points); }

  [[nodiscard]] bool stable() const { return stable_; }

  /// The pairs listed: all whose bounding spheres meet, and more; where several ranks have the
  /// tiles, those of this one's sites. Empty when nearly all do.
  [[nodiscard]] Buffer<Pair> listed() const { return lists_.pairs(); }
  /// Those that were added to the list, in order.
  [[nodiscard]] std::span<const Pair> added_pairs() const { return lists_.added(); }

 private:
  struct Worker {
    PairSwapper<Scalar> swap;
    PassCount count;
    std::vector<Pair> swapped;
    Index streamed = 0;  ///< points of pairs since the last look whether to stop
  };

  void full_pass(LevelState<Scalar>& state);
  template <class Source>
  void run(Source&& source, const Tiling& tiling, bool full, LevelState<Scalar>& state);
  void examine(LevelState<Scalar>& state, Worker& worker, SiteNumber i, SiteNumber j);
  Index update_changed(LevelState<Scalar>& state, bool full);
  PassCount count(bool full, const Tiling& tiling);
  void forget_pairs();
  bool cancelled() { return stopped_ = stopped_ || stop_.requested(); }

  const Metric& metric_;
  const Options& options_;
  const Arena& arena_;
  Stop& stop_;
  PerWorker<Worker> workers_;

  Patches<Scalar> patches_;
  Bands<Scalar> bands_;
  PairLists lists_;
  Screen<Scalar> screen_;
  Loans loans_;
  std::vector<std::uint8_t> changed_;       ///< sites, in this pass
  std::vector<std::uint8_t> touched_;       ///< sites, since the last full pass began
  std::vector<std::uint8_t> touched_tile_;  ///< tiles with touched sites
  std::vector<Pair> cache_;                 ///< pairs that swapped in the last pass
  int cached_passes_ = 0;                   ///< since the last full pass
  bool cells_are_large_ = false;            ///< most of them: they have bands
  bool stable_ = false;
  bool stopped_ = false;
};

/// Moves every site to the centroid of its cell.
template <class Scalar>
void update_all(const Metric& metric, LevelState<Scalar>& state, const Arena& arena);

extern template class Relaxer<float>;
extern template class Relaxer<double>;

}  // namespace ccvt
