#pragma once

#include "ccvt/domain.h"

namespace ccvt {

/// The box of a torus on which all distances of points in the domain's box are those of the domain:
/// this box itself, where all of it is periodic. Where a dimension is not, the torus is so much
/// longer than the box that the way round it is never the shorter one, and what is near a face of
/// the box is not near one of the torus.
inline Box torus_of(const Domain& domain) {
  constexpr double kBelow = 1.0 / 16;
  constexpr double kAbove = 1 + kBelow;
  Box torus = domain.box();
  for (int d = 0; d < torus.dimension(); ++d) {
    if (domain.is_periodic(d)) continue;
    const double extent = torus.upper[d] - torus.lower[d];
    torus.lower[d] -= kBelow * extent;
    torus.upper[d] += kAbove * extent;
  }
  return torus;
}

}  // namespace ccvt
