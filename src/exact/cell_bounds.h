#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/types.h"
#include "exact/grouping.h"
#include "exact/move_costs.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/rank_turns.h"

namespace ccvt {

/// For each cell and each site, no more than what moving a point of the cell there costs, without
/// weights: the least of |p - j|^2 - |p - i|^2 over the points of cell i. Kept from pricing to
/// pricing, so that only cells are looked at that sites come near [Elkan 2003, where points have
/// bounds; here cells have].
///
/// When sites move, bounds follow: |p - j|^2 changes by what it does seen from site i, less twice
/// the farthest point's distance times the step at most. 8 n^2 bytes, and 12 a point.
///
/// Ranks that all have all points take turns in the cells: each has the bounds of its own only, and
/// what is done to those of others does nothing.
class CellBounds {
 public:
  /// Whether there is memory for them, and a metric in which they follow.
  [[nodiscard]] static bool fit(const Metric& metric, std::size_t sites);

  CellBounds(std::size_t points, std::size_t sites, const RankTurns& turns = RankTurns());

  /// Whether the bounds of the cell are here.
  [[nodiscard]] bool has(SiteNumber site) const { return turns_.own(site); }

  /// Whether the bounds are those of cells with these owners.
  [[nodiscard]] bool cover(const std::vector<Index>& owners) const {
    return valid_ && covered_ == owners;
  }
  /// They cover nothing until all points are included, or all bounds set anew.
  void invalidate() { valid_ = false; }
  /// Nothing is known any more; bounds are to be set for these positions.
  void forget(std::span<const double> sites);
  /// From the positions before to these. The groups are those that bounds cover. O(n^2 D) at worst.
  template <class Scalar>
  void follow(std::span<const double> sites, const Grouping& groups, PointsView<Scalar> points,
              const Arena& arena);
  /// All bounds are those of cells with these owners.
  void set_covered(std::vector<Index> owners) {
    covered_ = std::move(owners);
    valid_ = true;
  }

  [[nodiscard]] std::span<double> of(SiteNumber site) {
    return std::span(bounds_).subspan(turns_.place_of(site) * count(), count());
  }
  [[nodiscard]] std::span<const double> of(SiteNumber site) const {
    return std::span(bounds_).subspan(turns_.place_of(site) * count(), count());
  }
  /// The sites, in `near`, that some point of the cell may prefer, under these weights, besides the
  /// cell's own.
  void select(SiteNumber site, std::span<const double> weights,
              std::vector<SiteNumber>& near) const;
  /// Whether there are any.
  [[nodiscard]] bool any_near(SiteNumber site, std::span<const double> weights) const;
  /// What moving a point of a cell to another costs at least, but for rounding.
  void set(SiteNumber site, SiteNumber other, double cost);

  /// What moving a point of a cell costs at least, to each site.
  void raise(SiteNumber site, std::span<const double> least);

  /// The bounds of a cell whose points may have come since: those that did are added.
  std::span<const double> include(SiteNumber site, std::span<const PointNumber> members,
                                  const MoveCosts& costs, MoveCosts::Scratch& scratch);
  /// A point that comes to a cell, no more than its squared distances to all sites, and that to its
  /// own.
  void include(SiteNumber site, PointNumber point, std::span<const double> squared, double own);
  /// A point that comes to a cell at that squared distance, to be included later.
  void widen(SiteNumber site, double own);
  /// All points that came anywhere since. `costs`: for the positions that bounds are for.
  void include_all(const std::vector<Index>& owners, const MoveCosts& costs, const Arena& arena);
  /// The bounds of cells with these owners anew, by products. include_all() says when they cover
  /// them. O(m n D).
  void set_all(const std::vector<Index>& owners, const MoveCosts& costs, const Arena& arena);
  void remove(PointNumber point) { covered_[point] = kNowhere; }

  /// |p - site|^2 of each point and the site of its cell.
  [[nodiscard]] std::vector<double>& own_costs() { return own_costs_; }
  /// How far the farthest point of a cell is from its site, at most.
  [[nodiscard]] double& radius(SiteNumber site) { return radius_[site]; }

 private:
  static constexpr Index kNowhere = -1;
  [[nodiscard]] std::size_t count() const { return radius_.size(); }
  void count_in(SiteNumber site, std::span<const PointNumber> points, const MoveCosts& costs,
                MoveCosts::Scratch& scratch);
  template <class Scalar>
  double step(SiteNumber site, const double* to, std::span<const PointNumber> members,
              PointsView<Scalar> points, std::vector<double>& squared);
  void lower(SiteNumber site, double growth);
  template <class Visit>
  void for_near(SiteNumber site, std::span<const double> weights, const Visit& visit) const;

  RankTurns turns_;
  bool valid_ = false;
  std::vector<double> bounds_;  ///< of the k-th cell that is here and site j at [k * n + j]
  std::vector<double> radius_;
  std::vector<double> own_costs_;
  std::vector<Index> covered_;  ///< of each point, the cell whose bounds count it
  std::vector<double> sites_;
  int dimension_ = 0;
};

}  // namespace ccvt
