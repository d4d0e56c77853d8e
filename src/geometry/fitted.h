#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "ccvt/domain.h"
#include "geometry/coordinate_range.h"

namespace ccvt {

/// The domain with another box along the dimensions that are not periodic, if there are such beside
/// periodic ones: that around what is in it. Distances are the same, but there sites may lie
/// outside the domain's own box, which on a torus would be on its other side; and where that is far
/// too large, so would the torus be, and cost digits.
inline Domain fitted(const Domain& domain, const Box& around) {
  if (!domain.is_partly_periodic()) return domain;
  Box box = domain.box();
  std::vector<bool> along;
  double period = std::numeric_limits<double>::infinity();
  for (int d = 0; d < box.dimension(); ++d) {
    along.push_back(domain.is_periodic(d));
    if (along.back()) period = std::min(period, box.upper[d] - box.lower[d]);
  }
  for (int d = 0; d < box.dimension(); ++d) {
    const double extent = around.upper[d] - around.lower[d];
    if (domain.is_periodic(d) || !std::isfinite(extent)) continue;
    // A torus as thin as the rounding of coordinates would be none.
    const double size = std::max(std::abs(around.lower[d]), std::abs(around.upper[d]));
    const double least = 0x1p-20 * std::max(size, period);
    box.lower[d] = around.lower[d] - (extent < least ? least : 0);
    box.upper[d] = around.upper[d] + (extent < least ? least : 0);
  }
  return Domain::periodic(std::move(box), along);
}

/// The smallest around a box and points, of which there may be none.
template <class Scalar>
Box widened(Box box, const PointsView<Scalar>& points) {
  if (points.count == 0) return box;
  const Box other = box_around(points, Arena(1));
  for (int d = 0; d < box.dimension(); ++d) {
    box.lower[d] = std::min(box.lower[d], other.lower[d]);
    box.upper[d] = std::max(box.upper[d], other.upper[d]);
  }
  return box;
}

/// The domain that distances between points and sites are measured in, see fitted().
template <class Scalar, class... Sites>
Domain measured_domain(const Domain& domain, const PointsView<Scalar>& points,
                       const Sites&... sites) {
  if (!domain.is_partly_periodic() || points.count == 0) return domain;
  Box around = box_around(points, Arena(1));
  ((around = widened(std::move(around), sites)), ...);
  return fitted(domain, around);
}

}  // namespace ccvt
