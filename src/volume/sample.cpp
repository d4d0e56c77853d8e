#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "parallel/arena.h"
#include "point_count.h"
#include "sampling/density_mass.h"

namespace ccvt {

namespace {

/// Capacities and radii, from the points of each cell. A run that was cancelled on a coarse level
/// has points without an owner, -1; they count for nothing.
template <class Scalar>
void measure_cells(const Points<Scalar>& points, const std::vector<Index>& owners,
                   VolumeSamples<Scalar>& samples) {
  const auto sites = static_cast<std::size_t>(samples.sites.cols());
  std::vector<double> squared(sites);
  samples.capacities.assign(sites, 0);
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Index site = owners[static_cast<std::size_t>(p)];
    if (site < 0) continue;
    ++samples.capacities[static_cast<std::size_t>(site)];
    for (Eigen::Index d = 0; d < points.rows(); ++d) {
      const double difference =
          static_cast<double>(points(d, p)) - static_cast<double>(samples.sites(d, site));
      squared[static_cast<std::size_t>(site)] += difference * difference;
    }
  }
  const auto dimension = static_cast<double>(points.rows());
  samples.radii.resize(sites);
  for (std::size_t s = 0; s < sites; ++s) {
    samples.radii[s] = std::sqrt((dimension + 2) / dimension * squared[s] / samples.capacities[s]);
  }
}

}  // namespace

void VolumeOptions::validate() const {
  if (points_per_site < 1) {
    throw InvalidInput("points_per_site: is " + std::to_string(points_per_site) +
                       "; must be at least 1");
  }
  tessellation.validate();
}

template <class Scalar>
VolumeSamples<Scalar> sample_volume(const DensityGrid& density, Index sites,
                                    const VolumeOptions& options) {
  options.validate();
  const Index count = checked_point_count(sites, options.points_per_site);
  const Points<Scalar> points =
      sample_density<Scalar>(density, count, options.tessellation.seed, options.sampling,
                             options.tessellation.threads, options.tessellation.cancelled);
  Solver<Scalar> solver(Problem<Scalar>(points, sites), options.tessellation);
  solver.run();
  VolumeSamples<Scalar> samples;
  samples.sites = solver.sites();
  samples.summary = solver.summary();
  measure_cells(points, solver.owners(), samples);

  const double mass = density_mass(density, Arena(options.tessellation.threads));
  std::int64_t owned = 0;
  for (const Index capacity : samples.capacities) owned += capacity;
  for (const Index capacity : samples.capacities) {
    samples.weights.push_back(mass * capacity / static_cast<double>(owned));
  }
  return samples;
}

template CCVT_EXPORT VolumeSamples<float> sample_volume<float>(const DensityGrid&, Index,
                                                               const VolumeOptions&);
template CCVT_EXPORT VolumeSamples<double> sample_volume<double>(const DensityGrid&, Index,
                                                                 const VolumeOptions&);

}  // namespace ccvt
