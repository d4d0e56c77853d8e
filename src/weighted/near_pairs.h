#pragma once

#include <vector>

#include "relax/meeting_pairs.h"

namespace ccvt {

/// The pairs of cells that may exchange points: those whose bounding spheres meet. Where these are
/// very many, as in many dimensions, each site and the nearest ones, as they are at the first call.
class NearPairs {
 public:
  /// Of each site.
  static constexpr int kNearest = 32;

  /// For where sites and their radii are now; in order, each once, some of which do not meet yet.
  std::vector<Pair> list(const Metric& metric, const SiteState& sites, const Arena& arena);

  /// Pairs of cells that lie side by side, whatever strays they own: the Gabriel graph of the
  /// sites, or, where that would take long, each site and the 8 nearest.
  std::vector<Pair> side_by_side(const Metric& metric, const SiteState& sites, const Arena& arena);

 private:
  MeetingPairs meeting_;
  std::vector<Pair> nearest_;
};

}  // namespace ccvt
