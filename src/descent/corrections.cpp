// By how much the weights of a diagram must change so that its cells are full.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "descent/borders.h"
#include "relax/potential.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 64;
/// Points that a border has at the least: cells that do not meet now may come to.
constexpr double kLeastMass = 1e-3;
/// Of a float, whose sums over edges are finite still.
constexpr double kLargestDensity = 1e30;

}  // namespace

template <class Scalar>
std::vector<double> Borders<Scalar>::correction() const {
  std::vector<double> lack(surplus_);
  for (double& l : lack) l = -l;
  return weights_for(lack);
}

/// How many points leave from each view's cell to its site. When site s takes the step u, and its
/// weight grows by |u|^2, its power at a point p grows by -2 (p - s) . u; so many points as have
/// less than the difference to their next owner's leave.
template <class Scalar>
std::vector<double> Borders<Scalar>::leaving(std::span<const double> step) const {
  std::vector<double> leaving(views_.count());
  for_each_site(arena_, tiling_, [&](SiteNumber s) {
    const double* const own = views_.at(views_.own(s));
    for (const View view : views_.of(s)) {
      const double* const other = views_.at(view);
      const double* const sum = &at_border_[view * sum_size() + 1];
      double change = 0;
      for (std::size_t d = 0; d < dimension_; ++d) {
        change += (sum[d] - mass(view) * other[d]) * step[views_.site(view) * dimension_ + d] -
                  (sum[d] - mass(view) * own[d]) * step[s * dimension_ + d];
      }
      leaving[view] = change / width_[s];
    }
  });
  share_leaving(leaving);
  return leaving;
}

template <class Scalar>
std::vector<double> Borders<Scalar>::correction(std::span<const double> step) const {
  const std::vector<double> from = leaving(step);
  std::vector<double> lack(capacity_.size());
  for_each_site(arena_, capacity_.size(), kSitesPerGrain, [&](SiteNumber s) {
    for (const View view : views_.of(s)) lack[s] += from[view] - from[views_.twin(view)];
  });
  return weights_for(lack);
}

/// By how much each weight must grow so that, to first order, sites have so many points more.
template <class Scalar>
std::vector<double> Borders<Scalar>::weights_for(std::span<const double> lack) const {
  const std::size_t sites = capacity_.size();
  WeightedGraph graph{std::vector<std::size_t>(sites + 1), {}, {}};
  for (const SiteNumber s : sites_below(sites)) graph.first[s] = views_.own(s) - s;
  graph.first[sites] = views_.count() - sites;
  graph.neighbour.resize(graph.first.back());
  graph.weight.resize(graph.neighbour.size());
  // Densities are of points over squares of lengths: in the unit of a square they are for floats.
  const double unit = std::exp2(std::ilogb(*std::max_element(width_.begin(), width_.end())));
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    std::size_t edge = graph.first[s];
    for (const View view : views_.of(s)) {
      const SiteNumber other = views_.site(view);
      if (other == s) continue;
      const double density = (mass(view) + kLeastMass) / (2 * width_[s]) +
                             (mass(views_.twin(view)) + kLeastMass) / (2 * width_[other]);
      graph.neighbour[edge] = other;
      graph.weight[edge++] = static_cast<float>(std::min(density * unit, kLargestDensity));
    }
  });
  std::vector<double> weights = potential(graph, lack, arena_);
  for (double& weight : weights) weight *= unit;
  return weights;
}

#define CCVT_INSTANTIATE(Scalar)                                                            \
  template std::vector<double> Borders<Scalar>::leaving(std::span<const double>) const;     \
  template std::vector<double> Borders<Scalar>::weights_for(std::span<const double>) const; \
  template std::vector<double> Borders<Scalar>::correction() const;                         \
  template std::vector<double> Borders<Scalar>::correction(std::span<const double>) const;

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
