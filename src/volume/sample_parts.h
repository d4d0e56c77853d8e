#pragma once

#include <Eigen/Core>
#include <vector>

#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "sampling/grid_world.h"
#include "volume/cell_measures.h"

/// What one process and several do in the same way.
namespace ccvt {

/// What all that is measured of cells needs of a solver that has ended: its sites in the world, and
/// its record.
template <class Scalar>
VolumeSamples samples_of(const Solver<Scalar>& solver, const Points<Scalar>& sites,
                         const LocalDensity& local) {
  VolumeSamples samples;
  samples.scalar = sizeof(Scalar) == sizeof(float) ? ScalarType::float32 : ScalarType::float64;
  samples.summary = solver.summary();
  samples.sites = sites.template cast<double>().colwise() + local.origin;
  return samples;
}

inline CellMeasures measures_for(const LocalDensity& local, Index sites) {
  constexpr double kBeyond = 2;  // whatever is rounded
  return {static_cast<std::size_t>(sites), kBeyond * world_box(local.grid).extent().stableNorm()};
}

/// Every site's share of the integral of the density.
inline void weigh_cells(double mass, VolumeSamples& samples) {
  double owned = 0;
  for (const Index capacity : samples.capacities) owned += capacity;
  for (const Index capacity : samples.capacities) {
    samples.weights.push_back(mass * capacity / owned);
  }
}

}  // namespace ccvt
