#include "exact/assignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "ccvt/capacity.h"
#include "cell_sizes.h"
#include "exact/weighted_sites.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// What owners lack that do not meet the capacities.
constexpr double kUnmet = std::numeric_limits<double>::infinity();
/// After so many rounds that do not bring the gap down to this share, rounding leaves no smaller
/// one.
constexpr int kIdleRounds = 4;
constexpr double kSmallerGap = 0.9;

}  // namespace

template <class Scalar>
ExactAssignment<Scalar>::ExactAssignment(const Metric& metric, PointsView<Scalar> points,
                                         Index sites, std::vector<Index> capacities,
                                         const Arena& arena, double gap, const RankPart& part)
    : metric_(metric),
      points_(points),
      capacities_(std::move(capacities)),
      floating_(capacities_.empty()),
      arena_(arena),
      part_(part),
      count_(static_cast<Index>(total(part.ranks, points.count))),
      pricer_(metric, points, arena, part),
      gap_(gap) {
  if (floating_) capacities_ = equal_capacities(count_, sites);
  const auto count = static_cast<std::size_t>(sites);
  if (CellBounds::fit(metric, count)) {
    const RankTurns turns(sharing(arena, part));
    kept_.emplace(static_cast<std::size_t>(points.count), count, turns);
  }
  fewer_ = count_ / sites;
  larger_ = count_ % sites;
}

/// Gives the larger capacities to the sites of least weight.
template <class Scalar>
void ExactAssignment<Scalar>::float_capacities(const std::vector<double>& weights) {
  if (!floating_) return;
  std::vector<std::size_t> by_weight(weights.size());
  std::iota(by_weight.begin(), by_weight.end(), std::size_t{0});
  std::sort(by_weight.begin(), by_weight.end(), [&](std::size_t a, std::size_t b) {
    return weights[a] != weights[b] ? weights[a] < weights[b] : a < b;
  });
  Index left = larger_;
  for (const std::size_t s : by_weight) capacities_[s] = left-- > 0 ? fewer_ + 1 : fewer_;
}

/// By how much the sum of size * weight over the cells exceeds the least that capacities allow;
/// kUnmet when they are not met. Capacities are those of float_capacities().
template <class Scalar>
double ExactAssignment<Scalar>::capacity_gap(const std::vector<double>& weights,
                                             const std::vector<Index>& owners) const {
  const std::vector<Index> sizes = summed(part_.ranks, cell_sizes(owners, weights.size()));
  // Excesses sum to zero, so weights count by their differences; the sum is better off with those.
  const double lowest = *std::min_element(weights.begin(), weights.end());
  double gap = 0;
  for (std::size_t s = 0; s < sizes.size(); ++s) {
    const Index excess = sizes[s] - capacities_[s];
    const bool met = excess == 0 || (floating_ && (sizes[s] == fewer_ || sizes[s] == fewer_ + 1));
    if (!met) return kUnmet;
    gap += excess * (weights[s] - lowest);
  }
  return gap;
}

/// A gap that rounding alone can cause: that of sums. Squared distances are the same wherever they
/// decide, and rounded as a share of themselves, or, on a torus, of its extent, however far points
/// are from the origin.
template <class Scalar>
double ExactAssignment<Scalar>::rounding(double energy, const std::vector<double>& weights) const {
  const auto [low, high] = std::minmax_element(weights.begin(), weights.end());
  const double m = count_;
  const double underflow = m * points_.dimension * std::numeric_limits<double>::min();
  return 1e-15 * (points_.dimension * energy + m * (*high - *low)) + underflow;
}

/// Of the owners that were priced.
template <class Scalar>
void ExactAssignment<Scalar>::set_certificate(const Prices& prices,
                                              const std::vector<double>& weights,
                                              const std::vector<Index>& owners) {
  ++certificate_.rounds;
  certificate_.energy = prices.energy;
  certificate_.worst = prices.worst;
  float_capacities(weights);
  certificate_.gap = prices.gap + capacity_gap(weights, owners);
}

template <class Scalar>
Certificate ExactAssignment<Scalar>::certify(std::span<const double> sites,
                                             std::vector<double>& weights,
                                             const std::vector<Index>& owners) {
  bring_near_zero(weights);
  std::vector<Index> cheapest = owners;
  set_certificate(pricer_.price({sites, weights}, cheapest), weights, owners);
  return certificate_;
}

template <class Scalar>
auto ExactAssignment<Scalar>::improve(std::span<const double> sites, std::vector<double>& weights,
                                      std::vector<Index>& owners) -> Round {
  std::vector<Index> given = owners;
  bring_near_zero(weights);
  CellBounds* const kept = kept_ ? &*kept_ : nullptr;
  const bool followed = kept_ && kept_->cover(owners);
  const Prices prices = pricer_.price({sites, weights}, owners, kept);
  set_certificate(prices, weights, given);
  if (certificate_.gap <= std::max(gap_ * prices.energy, rounding(prices.energy, weights))) {
    owners = std::move(given);
    return Round::optimal;
  }
  SquaredDistances<Scalar> costs(metric_, points_, sites);
  // Of sites that were too far to be priced, first bounds tell little: searches would weigh the
  // edges to them, one by one (65536 x 64-D, K = 1024: this round would take .9 s, not .6).
  if (kept_ && !followed && prices.moved > std::ssize(weights)) {
    kept_->set_all(owners, costs, arena_);
  }
  ExchangeGraph graph(capacities_, floating_, owners, weights, costs, kept, part_);
  if (kept_) kept_->invalidate();
  graph.settle(arena_);
  if (kept_) kept_->include_all(owners, costs, arena_);
  certificate_.augmentations += graph.augmentations();
  return Round::met;
}

template <class Scalar>
Certificate ExactAssignment<Scalar>::solve(std::span<const double> sites,
                                           std::vector<double>& weights,
                                           std::vector<Index>& owners) {
  certificate_ = {};
  struct Best {
    std::vector<Index> owners;
    std::vector<double> weights;
    Certificate certificate;
  } best;
  best.certificate.gap = kUnmet;
  for (int idle = 0; idle < kIdleRounds; ++idle) {
    std::vector<Index> given = owners;
    std::vector<double> weights_given = weights;
    if (improve(sites, weights, owners) == Round::optimal) return certificate_;
    // What proves owners optimal is to owe nothing to what found them.
    if (kept_) kept_->invalidate();
    if (!(certificate_.gap < best.certificate.gap)) continue;
    if (certificate_.gap < kSmallerGap * best.certificate.gap) idle = -1;
    best = {std::move(given), std::move(weights_given), certificate_};
  }
  if (best.owners.empty()) return certificate_;
  owners = std::move(best.owners);
  weights = std::move(best.weights);
  best.certificate.rounds = certificate_.rounds;
  best.certificate.augmentations = certificate_.augmentations;
  return certificate_ = best.certificate;
}

template class ExactAssignment<float>;
template class ExactAssignment<double>;

}  // namespace ccvt
