#pragma once

#include <cmath>

#include "random.h"

namespace ccvt::bench {

/// A number of the standard normal distribution [Box, Muller 1958]. Takes two uniform ones.
inline double normal(Random& random) {
  const double radius = std::sqrt(-2 * std::log(1 - random.uniform()));
  return radius * std::cos(2 * std::acos(-1.0) * random.uniform());
}

}  // namespace ccvt::bench
