#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "geometry/metric.h"
#include "parallel/bytes.h"
#include "parallel/loops.h"
#include "relax/site_state.h"
#include "schedule/pair.h"
#include "schedule/tiling.h"
#include "spatial/site_search.h"

namespace ccvt {

/// The pairs of sites whose bounding spheres meet [5.1], found by a spatial search.
///
/// Every sphere is grown by a skin when it is entered. A pair that is not listed cannot meet for as
/// long as each sphere stays inside its grown one, so the list serves many passes. The few spheres
/// that do leave theirs are entered anew, at where they are.
class MeetingPairs {
 public:
  enum class Refreshed { unchanged, extended, rebuilt, too_many };

  /// Makes the list hold every pair whose spheres meet now. O(n) when it still does, O(n log n +
  /// pairs) when it has to be made again. Gives up with `too_many` when that takes more than
  /// `limit` pairs, of all ranks; the list is then empty.
  Refreshed refresh(const Metric& metric, const SiteState& sites, const Tiling& tiling,
                    const Arena& arena, std::size_t limit);

  /// The next refresh() builds the list anew.
  void forget() { search_.reset(); }

  /// Of the list, what it takes to make it again, O(n); load() does, in the time of refresh().
  /// `added`: added() of all ranks.
  void save(ByteWriter& out, std::span<const Pair> added) const;
  void load(ByteReader& in, const Metric& metric, const Tiling& tiling, const Arena& arena);

  /// Pairs listed when the list was made, and those added since, sorted; first site < second site.
  [[nodiscard]] std::span<const Pair> pairs() const { return pairs_.items; }
  [[nodiscard]] std::span<const Pair> added() const { return added_; }

 private:
  struct Group {
    SiteSearch search;
    double largest_reach;
  };
  /// Spheres as they were entered when the list was made.
  struct Entered {
    std::vector<SiteNumber> site;
    std::vector<double> position;
    std::vector<double> reach;
  };

  [[nodiscard]] Group group(const Metric& metric, std::span<const SiteNumber> sites,
                            const Arena& arena) const;
  [[nodiscard]] Buffer<SiteNumber> outgrown(const Metric& metric, const SiteState& sites,
                                            const Tiling& tiling, const Arena& arena) const;
  void enter(const SiteState& sites, SiteNumber site);
  [[nodiscard]] bool may_meet(SiteNumber a, SiteNumber b, double squared) const;
  bool build(const Metric& metric, const SiteState& sites, const Tiling& tiling, const Arena& arena,
             std::size_t limit);
  bool list(const Metric& metric, const Tiling& tiling, const Arena& arena, std::size_t limit);
  bool extend(const Metric& metric, const SiteState& sites, const Tiling& tiling,
              std::span<const SiteNumber> left, const Arena& arena);
  [[nodiscard]] bool listed(const Pair& pair) const;
  [[nodiscard]] const double* at(SiteNumber site) const { return &position_[site * dimension_]; }

  std::size_t dimension_ = 0;
  Groups<Pair> pairs_;  ///< by their first site
  std::vector<Pair> added_;
  std::vector<double> position_;      ///< of each sphere when it was entered
  std::vector<double> reach_;         ///< its radius and skin
  std::optional<SiteSearch> search_;  ///< among the sites where they were when the list was made
  std::vector<SiteNumber> moved_;     ///< entered since: the search has them where they were
  Entered before_;                    ///< these, in the order in which they moved
  Buffer<SiteNumber> far_;            ///< spheres that reach farther than usual_reach_
  std::optional<Group> far_group_;
  double usual_reach_ = 0;
};

}  // namespace ccvt
