#pragma once

#include <Eigen/Core>
#include <vector>

#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "sampling/grid_world.h"
#include "volume/cell_measures.h"

/// What one process and several do in the same way.
namespace ccvt {

/// Of a solver that has ended its sites in the world and its record, and capacities and radii of
/// its cells; of several ranks each has some of the points.
template <class Scalar>
VolumeSamples samples_of(const Solver<Scalar>& solver, PointsView<Scalar> points,
                         const std::vector<Index>& owners, const LocalDensity& local,
                         const Arena& arena, Ranks* ranks = nullptr) {
  constexpr double kBeyond = 2;  // whatever is rounded
  const Points<Scalar> sites = solver.sites();
  VolumeSamples samples;
  samples.scalar = sizeof(Scalar) == sizeof(float) ? ScalarType::float32 : ScalarType::float64;
  samples.summary = solver.summary();
  samples.sites = sites.template cast<double>().colwise() + local.origin;
  CellMeasures measures(static_cast<std::size_t>(sites.cols()),
                        kBeyond * world_box(local.grid).extent().stableNorm());
  measures.add(points, view_points(sites), owners, arena);
  if (ranks != nullptr) measures.add_up(*ranks);
  measures.put(points.dimension, samples);
  return samples;
}

/// Every site's share of the integral of the density.
inline void weigh_cells(double mass, VolumeSamples& samples) {
  double owned = 0;
  for (const Index capacity : samples.capacities) owned += capacity;
  for (const Index capacity : samples.capacities) {
    samples.weights.push_back(mass * (capacity / owned));  // finite where the mass is
  }
}

}  // namespace ccvt
