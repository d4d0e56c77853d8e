#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "compensated_sum.h"
#include "geometry/metric.h"

namespace ccvt {

/// How masses lie around a place.
struct MassSpread {
  double energy = 0;          ///< sum of mass times squared distance
  double squared_radius = 0;  ///< of the farthest
};

/// One move of a place to the centre of mass of the images of some points nearest to it, and how
/// they lie around it then. at(member): a point's coordinates; mass(member): above 0; they sum to
/// `total`. Returns whether the move made other images nearest.
template <class Members, class At, class Mass>
bool move_to_centre(const Metric& metric, const Members& members, const At& at, const Mass& mass,
                    double total, double* position, MassSpread& spread) {
  const std::size_t width = metric.coordinate_count();
  const std::vector<double> old(position, position + width);
  std::vector<double> shift(width, 0.0);
  for (const auto& member : members) {
    const auto* const x = at(member);
    for (std::size_t d = 0; d < width; ++d)
      shift[d] += mass(member) * metric.wrap(x[d] - old[d], d);
  }
  for (std::size_t d = 0; d < width; ++d) {
    shift[d] /= total;
    position[d] = metric.into_box(old[d] + shift[d], d);
  }
  bool changed = false;
  CompensatedSum energy;
  spread.squared_radius = 0;
  for (const auto& member : members) {
    const auto* const x = at(member);
    double squared = 0;
    for (std::size_t d = 0; d < width; ++d) {
      const double after = metric.wrap(x[d] - position[d], d);
      squared += after * after;
      if (!metric.periodic()) continue;
      const double before = metric.wrap(x[d] - old[d], d);
      changed = changed || std::abs(before - shift[d] - after) > metric.extent()[d] / 2;
    }
    energy.add(mass(member) * squared);
    spread.squared_radius = std::max(spread.squared_radius, squared);
  }
  spread.energy = energy.value();
  return changed;
}

/// As many of these moves as lower the energy: each does, unless it makes no other image nearest.
template <class Members, class At, class Mass>
MassSpread rest_at_centre(const Metric& metric, const Members& members, const At& at,
                          const Mass& mass, double total, double* position) {
  MassSpread spread;
  double before = std::numeric_limits<double>::infinity();
  while (move_to_centre(metric, members, at, mass, total, position, spread) &&
         spread.energy < before) {
    before = spread.energy;
  }
  return spread;
}

}  // namespace ccvt
