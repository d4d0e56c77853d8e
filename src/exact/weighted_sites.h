#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

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

/// Makes the highest weight 0. Only their differences count, and these lose digits where all are
/// far from 0: paths from one of two groups of points to the other, far away, lower all.
inline void bring_near_zero(std::vector<double>& weights) {
  const double highest = *std::max_element(weights.begin(), weights.end());
  for (double& weight : weights) weight -= highest;
}

}  // namespace ccvt
