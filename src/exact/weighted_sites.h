#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "median.h"
#include "numbers.h"

namespace ccvt {

/// n sites with a weight each; a point p costs site s the reduced cost |p - s|^2 - weight[s].
struct WeightedSites {
  WeightedSites(std::span<const double> positions, std::span<const double> weights)
      : position(positions), weight(weights), dimension(positions.size() / weights.size()) {}

  [[nodiscard]] std::size_t count() const { return weight.size(); }
  [[nodiscard]] const double* at(SiteNumber site) const {
    return position.data() + site * dimension;
  }

  std::span<const double> position;  ///< one site after the other
  std::span<const double> weight;
  std::size_t dimension;
};

/// Makes the median weight 0. Only their differences count, and these lose digits where most are
/// far from 0: paths from one of two groups of points to the other, far away, lower all, and a cell
/// with a point that is far away has a weight far from those of all others.
inline void bring_near_zero(std::vector<double>& weights) {
  std::vector<double> order = weights;
  const double middle = median(order);
  for (double& weight : weights) weight -= middle;
}

}  // namespace ccvt
