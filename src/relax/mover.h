#pragma once

#include <vector>

#include "geometry/metric.h"
#include "relax/filling.h"
#include "relax/site_state.h"

namespace ccvt {

/// Passes points from one site to others by the swap key [eq. 6]. One per worker: it owns scratch
/// memory.
template <class Scalar>
class Mover {
 public:
  Mover(const Metric& metric, const SiteState& sites, Filling<Scalar>& filling);

  /// Whose points move() moves: those in its cell and those that wait.
  void leave(SiteNumber from);
  /// Moves the `count` points that gain most, or lose least, by changing to `to`; fewer when there
  /// are not as many. Returns how many. O(points of the site).
  Index move(SiteNumber to, Index count);
  /// The points that still wait take free places in the cell, as far as there are some.
  void stay();

 private:
  struct Choice {
    Scalar key;
    Index place;
  };
  struct Better {
    bool operator()(const Choice& a, const Choice& b) const {
      return a.key != b.key ? a.key > b.key : a.place < b.place;
    }
  };

  void choose(Index wanted, Index places);
  void as_block();
  void place_cut(SiteNumber from, SiteNumber to);
  void keys_of(const Scalar* block, Index count, Scalar* keys);

  const Metric& metric_;
  const SiteState& sites_;
  Filling<Scalar>& filling_;
  SiteNumber from_ = SiteNumber::none();
  std::vector<Scalar> middle_;
  std::vector<Scalar> normal_;
  std::vector<Scalar> extent_;
  std::vector<Scalar> turn_;
  std::vector<Scalar> keys_;
  std::vector<PointOfAll> waiting_;  ///< of from_
  std::vector<Scalar> waiting_x_;    ///< their coordinates, point after point
  std::vector<Scalar> block_;
  std::vector<Scalar> moving_;   ///< coordinates of one point
  std::vector<Scalar> highest_;  ///< of each column
  std::vector<Scalar> sorted_;
  std::vector<Choice> choices_;
};

extern template class Mover<float>;
extern template class Mover<double>;

}  // namespace ccvt
