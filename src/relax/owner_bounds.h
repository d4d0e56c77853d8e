#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/loops.h"
#include "relax/site_state.h"

namespace ccvt {

/// A point, and the site that it is to change to.
struct OwnerChange {
  PointNumber point;
  SiteNumber to;
};

/// How far two squared distances, the greater of them that of `distance`, can be rounded apart.
double rounding_of_difference(const Metric& metric, double distance);

/// Which points are no longer nearest to their owners, from one position of the sites to the next.
///
/// For each point a bound is kept on how much nearer its owner is than any other site in the
/// owner's list: its lead. The moves of these sites use it up; only points without any left are
/// looked at [Hamerly 2010], and for these sites in the order of their distances from the owner,
/// which ends where none can be near enough [triangle inequality; Newling, Fleuret 2016]. What is
/// not listed is too far from the owner to be nearer to any of its points; when that is no longer
/// sure, lists are made anew.
template <class Scalar>
class OwnerBounds {
 public:
  OwnerBounds(const Metric& metric, const PointsView<Scalar>& points, const Arena& arena)
      : metric_(metric), points_(points), arena_(arena) {}

  /// Whether that is faster than to look at all points by a grid or tree of the sites.
  [[nodiscard]] static bool pays(Index points, Index sites, int dimension);

  /// The points for which another site is nearer than the owner by more than `margin` and what
  /// rounding can fake, in squared distance, and the nearest of these. `sites.radius` bounds the
  /// distance of a site's points. From now on such a point is taken to be owned by that site; all
  /// owners are as left by the last call. Same for any number of threads. Memory 4 bytes a point.
  Buffer<OwnerChange> changes(const SiteState& sites, const std::vector<Index>& owners,
                              double margin);

 private:
  struct Near {
    double distance;  ///< from the site
    SiteNumber site;
  };
  void list_near_sites(const SiteState& sites);
  void list_all_sites(const SiteState& sites);
  [[nodiscard]] bool lists_hold(const SiteState& sites) const;
  void pack(const SiteState& sites);
  void renew_lists(const SiteState& sites);
  void note_moves(const SiteState& sites);
  SiteNumber look_at(PointNumber point, SiteNumber owner, const SiteState& sites, double margin,
                     double* x, float& lead) const;

  const Metric& metric_;
  const PointsView<Scalar>& points_;
  const Arena& arena_;
  std::vector<double> position_;  ///< of the sites, in the last call
  std::vector<double> moved_;     ///< of each site, how far since then
  std::vector<float> used_;       ///< of each site, how much its points' leads fall
  std::vector<float> most_;       ///< of each site, the most that they can be
  std::vector<float> lead_;       ///< of each point
  /// The sites near each site, in packs; in many dimensions all, in one list.
  bool all_listed_ = false;
  std::vector<std::size_t> first_;  ///< pack of each site, and one more
  Buffer<Near> near_;               ///< none fill up the last pack
  Buffer<double> packs_;            ///< their positions, for the kernels
  std::vector<double> reach_;       ///< of each site, within which all sites are in near_
  double drift_ = 0;                ///< how far sites have moved since, at most
};

extern template class OwnerBounds<float>;
extern template class OwnerBounds<double>;

}  // namespace ccvt
