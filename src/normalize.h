#pragma once

#include <cmath>

#include "ccvt/metrics.h"
#include "ccvt/summary.h"

namespace ccvt {

/// Normals have no place in a box: the figure that their energy would have is taken back.
inline void count_normals(int dimensions, Summary& summary) {
  summary.normal_dimensions = dimensions;
  if (dimensions > 0) summary.normalized_energy = 0;
}

/// Sets Summary::normalized_energy from the other figures.
inline void normalize_energy(const Box& box, Summary& summary) {
  summary.normalized_energy = 0;
  if (!(box.extent().minCoeff() > 0)) return;
  const double energy = normalized_energy(summary.energy, summary.points, summary.sites, box);
  if (std::isfinite(energy)) summary.normalized_energy = energy;
}

}  // namespace ccvt
