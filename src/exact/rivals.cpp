#include "exact/rivals.h"

#include <limits>

#include "exact/distances.h"

namespace ccvt {
namespace {

/// The concave function is known at so many distances.
constexpr std::size_t kKnots = 64;

}  // namespace

void Rivals::tabulate() {
  least_.assign(kKnots, std::numeric_limits<double>::infinity());
  const double step = farthest_ / (kKnots - 1);
  for (std::size_t p = 0; p < squared_.size(); ++p) {
    const double constant = squared_[p] - reduced_[p];
    const double slope = 2 * step * std::sqrt(squared_[p]);
    for (std::size_t k = 0; k < kKnots; ++k) {
      least_[k] = std::min(least_[k], constant - slope * static_cast<double>(k));
    }
  }
}

/// By how much a site at that distance, without a weight, costs any point more than its owner does,
/// at least.
double Rivals::excess(double distance) const {
  const double place = farthest_ > 0 ? distance / farthest_ * (kKnots - 1) : 0;
  const std::size_t knot = std::min(static_cast<std::size_t>(place), kKnots - 2);
  const double share = place - static_cast<double>(knot);
  return distance * distance + least_[knot] * (1 - share) + least_[knot + 1] * share;
}

const std::vector<Rivals::Site>& Rivals::find(const SiteGroups& groups,
                                              std::span<const double> weights, const double* centre,
                                              int dimension) {
  farthest_ = groups.distances_to(centre, distance_);
  tabulate();
  const double relative = 4 * rounding_share(dimension);
  const double underflow = underflow_of(dimension);
  const auto may_cost_less = [&](double distance, double weight) {
    const double reach = distance + radius_;
    const double rounding = relative * (reach * reach + terms_ + std::abs(weight)) + underflow;
    return excess(distance) - weight <= rounding;
  };
  found_.clear();
  for (std::size_t g = 0; g < groups.count(); ++g) {
    // Beyond the farthest point costs rise with the distance.
    if (distance_[g] > radius_ && !may_cost_less(distance_[g], groups.weight[g])) continue;
    const auto sites = groups.of(g);
    groups.squared_to(centre, g, apart_);
    for (std::size_t k = 0; k < sites.size(); ++k) {
      if (may_cost_less(std::sqrt(apart_[k]), weights[sites[k]])) {
        found_.push_back({sites[k], apart_[k]});
      }
    }
  }
  return found_;
}

}  // namespace ccvt
