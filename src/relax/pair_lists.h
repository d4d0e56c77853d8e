#pragma once

#include <array>
#include <span>

#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/meeting_pairs.h"
#include "schedule/schedule.h"

namespace ccvt {

/// The pairs that meet, listed and scheduled, for as long as a list pays.
class PairLists {
 public:
  /// Brings the list up to date. False when (nearly) all pairs meet: a list would not pay.
  bool refresh(const Metric& metric, const SiteState& sites, const Tiling& tiling,
               const Arena& arena);
  /// The next refresh() lists all anew: after a pass that was left in the middle.
  void forget();

  /// `added`: added() of all ranks.
  void save(ByteWriter& out, std::span<const Pair> added) const;
  void load(ByteReader& in, const Metric& metric, const Tiling& tiling, const Arena& arena);

  /// The pairs listed first, and those added since.
  [[nodiscard]] std::array<const Schedule*, 2> schedules() const { return {&first_, &added_}; }
  /// The pairs listed, in no order, where several ranks have the tiles those of this one's sites;
  /// none when nearly all meet.
  [[nodiscard]] Buffer<Pair> pairs() const;
  /// Of them, those that have been added.
  [[nodiscard]] std::span<const Pair> added() const { return meeting_.added(); }

 private:
  MeetingPairs meeting_;
  Schedule first_;
  Schedule added_;
  bool dense_ = false;
  int dense_passes_ = 0;
};

}  // namespace ccvt
