#pragma once

#include "ccvt/types.h"
#include "random.h"
#include "support/normal.h"

namespace ccvt::bench {

/// `count` vectors of `components` Gaussian clouds with random centres and weights.
inline Points<float> mixture(Index count, int dimension, int components) {
  Random random(7, 3);
  Points<float> centres(dimension, components);
  for (Eigen::Index k = 0; k < centres.size(); ++k)
    centres.data()[k] = static_cast<float>(normal(random));
  Points<float> points(dimension, count);
  for (Index p = 0; p < count; ++p) {
    const double u = random.uniform();
    const auto component = static_cast<Eigen::Index>(u * u * components);  // uneven clouds
    for (int d = 0; d < dimension; ++d) {
      points(d, p) = centres(d, component) + static_cast<float>(0.5 * normal(random));
    }
  }
  return points;
}

}  // namespace ccvt::bench
