#include "exact/assignment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "ccvt/capacity.h"
#include "cell_sizes.h"

namespace ccvt {
namespace {

/// The slack is steered towards a number of offers a point between these, on average.
constexpr double kFewOffers = 0.5;
constexpr double kManyOffers = 2.0;
/// A surplus that is left over widens the slack as long as there are fewer offers than this, or no
/// point moved.
constexpr double kMostOffers = 8.0;
/// What owners lack that do not meet the capacities.
constexpr double kUnmet = std::numeric_limits<double>::infinity();
/// Offers that are added at once when a surplus is stuck.
constexpr std::int64_t kWidened = 8;

}  // namespace

template <class Scalar>
ExactAssignment<Scalar>::ExactAssignment(const Metric& metric, PointsView<Scalar> points,
                                         Index sites, std::vector<Index> capacities,
                                         const Arena& arena, double gap)
    : metric_(metric),
      points_(points),
      capacities_(std::move(capacities)),
      floating_(capacities_.empty()),
      arena_(arena),
      pricer_(metric, points, arena),
      gap_(gap) {
  if (floating_) capacities_ = equal_capacities(points.count, sites);
  fewer_ = points.count / sites;
  larger_ = points.count % sites;
  for (Index p = 0; p < points.count; ++p) {
    for (int d = 0; d < points.dimension; ++d) {
      const double x = points[p][d];
      largest_coordinate_ = std::max(largest_coordinate_, std::abs(x));
    }
  }
}

template <class Scalar>
WeightedSites ExactAssignment<Scalar>::weighted(std::span<const double> sites,
                                                const std::vector<double>& weights) const {
  return {sites, weights};
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
  const std::vector<Index> sizes = cell_sizes(owners, weights.size());
  double gap = 0;
  for (std::size_t s = 0; s < sizes.size(); ++s) {
    const Index excess = sizes[s] - capacities_[s];
    const bool met = excess == 0 || (floating_ && (sizes[s] == fewer_ || sizes[s] == fewer_ + 1));
    if (!met) return kUnmet;
    gap += excess * weights[s];
  }
  return gap;
}

/// A gap that rounding alone can cause.
template <class Scalar>
double ExactAssignment<Scalar>::rounding(double energy, const std::vector<double>& weights) const {
  const auto [low, high] = std::minmax_element(weights.begin(), weights.end());
  const double m = points_.count;
  const double distances = largest_coordinate_ * std::sqrt(points_.dimension * m * energy);
  const double underflow = m * points_.dimension * std::numeric_limits<double>::min();
  return 1e-15 * (points_.dimension * energy + m * (*high - *low) + distances) + underflow;
}

template <class Scalar>
auto ExactAssignment<Scalar>::improve(std::span<const double> sites, std::vector<double>& weights,
                                      std::vector<Index>& owners) -> Round {
  if (slack_ < 0) {
    std::vector<Index> cheapest = owners;
    const Prices first = pricer_.price(weighted(sites, weights), 0, 0, cheapest);
    slack_ = 0.1 / std::sqrt(points_.dimension) * first.cheapest_energy / points_.count;
    // All points at sites: any slack will do that is not nothing beside the distances.
    const double negligible = 1e-12 * first.energy / points_.count;
    if (!(slack_ > negligible)) slack_ = 1e-3 * first.energy / points_.count;
    if (slack_ == 0) slack_ = 1;
    // Owners that do not meet the capacities only group points; the cheapest do so better.
    if (capacity_gap(weights, owners) == kUnmet) owners = std::move(cheapest);
  }
  std::vector<Index> given = owners;
  const Prices prices = pricer_.price(weighted(sites, weights), slack_, weights.size(), owners);
  ++certificate_.rounds;
  certificate_.energy = prices.energy;
  certificate_.gap = prices.gap;
  certificate_.worst = prices.worst;
  float_capacities(weights);
  certificate_.gap += capacity_gap(weights, given);
  if (certificate_.gap <= std::max(gap_ * prices.energy, rounding(prices.energy, weights))) {
    owners = std::move(given);
    return Round::optimal;
  }
  const double budget = slack_;
  ExchangeGraph graph(capacities_, floating_, owners, weights);
  for (const Offer& offer : prices.offers) graph.add(offer);
  auto outcome = graph.settle(budget, arena_);
  while (outcome == ExchangeGraph::Outcome::closed) {
    widen(weighted(sites, weights), owners, graph);
    outcome = graph.settle(budget, arena_);
  }
  certificate_.augmentations += graph.augmentations();
  const double offers = static_cast<double>(prices.offers.size()) / points_.count;
  if (outcome == ExchangeGraph::Outcome::exhausted) {
    if (offers < kMostOffers || graph.augmentations() == 0) slack_ *= 2;
    return Round::incomplete;
  }
  if (offers > kManyOffers) slack_ *= 0.7;
  if (offers < kFewOffers) slack_ *= 1.5;
  return Round::met;
}

template <class Scalar>
Certificate ExactAssignment<Scalar>::solve(std::span<const double> sites,
                                           std::vector<double>& weights,
                                           std::vector<Index>& owners) {
  certificate_ = {};
  while (improve(sites, weights, owners) != Round::optimal) {
  }
  return certificate_;
}

/// Lets the sites that a surplus could not leave offer points to sites outside: those that cost
/// least. Weights then fall by what these cost more than their owners.
template <class Scalar>
void ExactAssignment<Scalar>::widen(const WeightedSites& sites, const std::vector<Index>& owners,
                                    ExchangeGraph& graph) const {
  std::vector<std::uint8_t> inside(sites.count(), 0);
  std::int64_t stuck = 0;
  for (const SiteNumber s : graph.reached()) {
    if (s == graph.hub()) continue;
    inside[s] = 1;
    stuck += graph.surplus(s);
  }
  std::vector<Offer> offers = pricer_.offers_outside(sites, slack_, inside, owners);
  const auto slack_of = [&](const Offer& offer) {
    return offer.key + sites.weight[offer.owner] - sites.weight[offer.to];
  };
  std::sort(offers.begin(), offers.end(), [&](const Offer& a, const Offer& b) {
    const double x = slack_of(a);
    const double y = slack_of(b);
    if (x != y) return x < y;
    return a.point != b.point ? a.point < b.point : a.to < b.to;
  });
  const double least = std::max(0.0, slack_of(offers.front()));
  const auto enough = static_cast<std::size_t>(std::max(kWidened, stuck));
  std::size_t kept = 0;
  for (; kept < offers.size(); ++kept) {
    if (kept >= enough && slack_of(offers[kept]) > least + slack_) break;
    graph.add(offers[kept]);
  }
  graph.lower_reached(least);
}

template class ExactAssignment<float>;
template class ExactAssignment<double>;

}  // namespace ccvt
