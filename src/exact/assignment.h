#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "exact/exchange.h"
#include "exact/pricing.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "parallel/rank_part.h"

namespace ccvt {

/// What shows how good an assignment that keeps the capacities is.
struct Certificate {
  double energy = 0;  ///< sum of squared distances to the owners, the primal objective
  /// Energy less the dual objective, sum over points of the least |p - s|^2 - w_s, plus sum over
  /// sites of capacity * w_s (the least such sum, where capacities float). No assignment that meets
  /// the capacities costs less than energy - gap.
  double gap = 0;
  /// By how much |p - s|^2 - w_s of an owner exceeds that of the cheapest site, at most.
  double worst = 0;
  int rounds = 0;                  ///< pricings of all points
  std::int64_t augmentations = 0;  ///< shortest paths along which points moved

  /// The gap over the energy; 1, which tells nothing, at most.
  [[nodiscard]] double share() const { return energy > 0 ? std::min(1.0, gap / energy) : 0; }
};

/// The assignment of points to fixed sites that keeps the capacities at the least sum of squared
/// distances: a transportation problem with n sinks, solved by pricing all points and settling the
/// surplus along shortest paths in the site graph.
///
/// A round gives every point its cheapest site under the weights at hand, then moves points until
/// capacities are met. The next pricing looks at all sites again that bounds do not rule out, and
/// that of a proof at all of them: if it finds nothing cheaper, weights and owners prove each other
/// optimal.
template <class Scalar>
class ExactAssignment {
 public:
  /// `metric`, `arena` and the points must outlive the object. No capacities: as equal as can be,
  /// with those that are larger by one where it costs least. `gap`: owners will do that are proved
  /// to cost at most so much more than the cheapest, as a share of what they cost. `part`: the
  /// points, and owners, are those of a rank; all ranks make the same calls.
  ExactAssignment(const Metric& metric, PointsView<Scalar> points, Index sites,
                  std::vector<Index> capacities, const Arena& arena, double gap = 0,
                  const RankPart& part = {});

  enum class Round {
    optimal,  ///< the owners given meet the capacities at the least cost, or within the gap of it:
              ///< they stay
    met,      ///< capacities are met, at the least cost but for rounding
  };
  /// Stopped, thrown by the arena, leaves owners that need not meet the capacities.
  ///
  /// One round, from any owners (used to group points, best near the truth) and weights. The nearer
  /// the weights are to the best ones, the fewer points have to go along paths.
  Round improve(std::span<const double> sites, std::vector<double>& weights,
                std::vector<Index>& owners);
  /// Rounds until the owners are proved optimal, but for rounding, or within the gap; or until
  /// further ones do not bring the gap down, which rounding may keep above what is expected of it.
  Certificate solve(std::span<const double> sites, std::vector<double>& weights,
                    std::vector<Index>& owners);

  /// How good owners that meet the capacities are, by what they cost and by these weights.
  Certificate certify(std::span<const double> sites, std::vector<double>& weights,
                      const std::vector<Index>& owners);

  /// Of the last round: what the owners given to it cost.
  [[nodiscard]] const Certificate& last() const { return certificate_; }

 private:
  void set_certificate(const Prices& prices, const std::vector<double>& weights,
                       const std::vector<Index>& owners);
  void float_capacities(const std::vector<double>& weights);
  [[nodiscard]] double capacity_gap(const std::vector<double>& weights,
                                    const std::vector<Index>& owners) const;
  [[nodiscard]] double rounding(double energy, const std::vector<double>& weights) const;

  const Metric& metric_;
  PointsView<Scalar> points_;
  std::vector<Index> capacities_;
  bool floating_;
  Index fewer_ = 0;   ///< the capacity of a site where they float, or one more
  Index larger_ = 0;  ///< how many sites have one more
  const Arena& arena_;
  RankPart part_;
  Index count_;  ///< of the points of all ranks
  Pricer<Scalar> pricer_;
  std::optional<CellBounds> kept_;
  double gap_;
  Certificate certificate_;
};

extern template class ExactAssignment<float>;
extern template class ExactAssignment<double>;

}  // namespace ccvt
