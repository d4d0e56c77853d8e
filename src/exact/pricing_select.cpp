// Which sites a part of the points is priced with.
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "exact/distances.h"
#include "exact/pricing_parts.h"

namespace ccvt {
namespace {

/// What a site costs points within a radius of a centre, of a given weight, more than a site there
/// would: `constant`, `reach` more or less, but for rounding.
struct Costs {
  Costs(double squared, double radius, double own, double weight, int dimension)
      : constant(squared + own - weight),
        reach(2 * radius * std::sqrt(squared)),
        rounding(rounding_share(dimension) * (squared + reach + std::abs(own) + std::abs(weight)) +
                 underflow_of(dimension)) {}
  double constant;
  double reach;
  double rounding;
};

}  // namespace

/// Gives the product the sites of groups that some point may prefer, or without owners those of the
/// part's group.
template <class Scalar>
void Pricer<Scalar>::select_by_groups(const Task& task, const Part& part, Scratch& scratch) const {
  const WeightedSites& sites = task.sites;
  const int dimension = points_.dimension;
  scratch.product.clear();
  const auto add = [&](SiteNumber j, double squared) {
    scratch.product.add(j, squared, squared - task.weight(j));
  };
  if (task.first) {
    for (const SiteNumber j : task.groups->of(part.group)) {
      add(j, squared_distance(part.centre, sites.at(j), dimension));
    }
  } else {
    for (const auto& [j, squared] :
         scratch.rivals.find(*task.groups, sites.weight, part.centre, dimension)) {
      add(j, squared);
    }
  }
}

/// Gives the product the sites that some point within the radius of the centre may prefer. `apart`:
/// squared distances between the centre and each site.
template <class Scalar>
void Pricer<Scalar>::select_sites(const Task& task, const Part& part, std::span<const double> apart,
                                  Scratch& scratch) const {
  const WeightedSites& sites = task.sites;
  const int dimension = points_.dimension;
  scratch.product.clear();
  scratch.least.resize(sites.count());
  // What the farthest point pays at most for its cheapest site, and what others cost at least; a
  // little more and less than that, for the rounding of these terms.
  double ceiling = kNever;
  for (const SiteNumber j : sites_below(sites.count())) {
    const double squared = apart[j];
    const auto [constant, reach, rounding] =
        Costs(squared, part.radius, part.weight, task.weight(j), dimension);
    scratch.least[j] = constant - reach - rounding;
    ceiling = std::min(ceiling, constant + reach + rounding);
    if (!part.bounds.empty()) part.bounds[j] = squared - reach - rounding;
  }
  for (const SiteNumber j : sites_below(sites.count())) {
    if (scratch.least[j] > ceiling) continue;
    const double squared = apart[j];
    scratch.product.add(j, squared, squared + part.weight - task.weight(j));
  }
}

/// The same from the bounds kept, of which those that the radius shows to be higher are raised.
template <class Scalar>
void Pricer<Scalar>::select_known(const Task& task, const Part& part, Scratch& scratch) const {
  task.kept->select(part.site, task.sites.weight, scratch.near);
  scratch.near.push_back(part.site);
  scratch.product.clear();
  for (const SiteNumber j : scratch.near) {
    const double squared =
        squared_distance(task.sites.at(part.site), task.sites.at(j), points_.dimension);
    const auto [constant, reach, rounding] =
        Costs(squared, part.radius, part.weight, task.weight(j), points_.dimension);
    if (constant - reach > rounding && j != part.site) {
      part.bounds[j] = std::max(part.bounds[j], squared - reach - rounding);
    } else {
      scratch.product.add(j, squared, constant);
    }
  }
}

/// To what the products have shown.
template <class Scalar>
void Pricer<Scalar>::raise_bounds(const Task& task, const Part& part,
                                  const CellProduct& product) const {
  const double own = task.weight(part.site);
  for (std::size_t n = 0; n < product.near().size(); ++n) {
    const SiteNumber j = product.near()[n];
    const double least = product.least(n);
    const double terms =
        std::abs(least) + std::abs(own) + std::abs(task.weight(j)) + std::abs(product.constant(n));
    const double rounding = rounding_share(points_.dimension) * terms;
    part.bounds[j] = std::max(part.bounds[j], least - (own - task.weight(j)) - rounding -
                                                  underflow_of(points_.dimension));
  }
}

#define CCVT_INSTANTIATE(Scalar)                                                                \
  template void Pricer<Scalar>::select_sites(const Task&, const Part&, std::span<const double>, \
                                             Scratch&) const;                                   \
  template void Pricer<Scalar>::select_by_groups(const Task&, const Part&, Scratch&) const;     \
  template void Pricer<Scalar>::select_known(const Task&, const Part&, Scratch&) const;         \
  template void Pricer<Scalar>::raise_bounds(const Task&, const Part&, const CellProduct&) const;

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
