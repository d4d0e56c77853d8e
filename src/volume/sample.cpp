#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "parallel/arena.h"
#include "point_count.h"
#include "sampling/cell_densities.h"
#include "sampling/density_mass.h"
#include "sampling/grid_world.h"

namespace ccvt {

namespace {

/// Capacities and radii, from the points of each cell.
template <class Scalar>
void measure_cells(const Points<Scalar>& points, const Points<Scalar>& sites,
                   const std::vector<Index>& owners, VolumeSamples& samples) {
  const auto count = static_cast<std::size_t>(sites.cols());
  std::vector<double> squared(count);
  samples.capacities.assign(count, 0);
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Index site = owners[static_cast<std::size_t>(p)];
    ++samples.capacities[static_cast<std::size_t>(site)];
    for (Eigen::Index d = 0; d < points.rows(); ++d) {
      const double difference =
          static_cast<double>(points(d, p)) - static_cast<double>(sites(d, site));
      squared[static_cast<std::size_t>(site)] += difference * difference;
    }
  }
  const auto dimension = static_cast<double>(points.rows());
  samples.radii.resize(count);
  for (std::size_t s = 0; s < count; ++s) {
    samples.radii[s] = std::sqrt((dimension + 2) / dimension * squared[s] / samples.capacities[s]);
  }
}

/// Every site's share of the integral of the density.
void weigh_cells(const DensityGrid& density, const Arena& arena, VolumeSamples& samples) {
  const double mass = density_mass(density, arena);
  std::int64_t owned = 0;
  for (const Index capacity : samples.capacities) owned += capacity;
  for (const Index capacity : samples.capacities) {
    samples.weights.push_back(mass * capacity / static_cast<double>(owned));
  }
}

/// Moves sites that are where the density is 0 to the nearest of their points: of several, the
/// first. `points` are relative to `origin`.
template <class Scalar>
void put_back(const DensityGrid& density, const Points<Scalar>& points,
              const Eigen::VectorXd& origin, const std::vector<Index>& owners,
              VolumeSamples& samples) {
  const CellDensities densities(density);
  const CellLocator cell_of(density);
  const auto count = static_cast<std::size_t>(samples.sites.cols());
  constexpr double unset = std::numeric_limits<double>::infinity();
  std::vector<double> least(count, -unset);  // squared distances, of sites that must move
  for (std::size_t s = 0; s < count; ++s) {
    const double* const site = samples.sites.col(static_cast<Eigen::Index>(s)).data();
    if (densities(cell_of(site)) > 0) continue;
    least[s] = unset;
    ++samples.put_back;
  }
  if (samples.put_back == 0) return;
  std::vector<Eigen::Index> nearest(count);
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const Index owner = owners[static_cast<std::size_t>(p)];
    if (least[static_cast<std::size_t>(owner)] < 0) continue;
    const double squared =
        (points.col(p).template cast<double>() + origin - samples.sites.col(owner)).squaredNorm();
    if (!(squared < least[static_cast<std::size_t>(owner)])) continue;
    least[static_cast<std::size_t>(owner)] = squared;
    nearest[static_cast<std::size_t>(owner)] = p;
  }
  for (std::size_t s = 0; s < count; ++s) {
    if (!(least[s] >= 0)) continue;
    samples.sites.eigen().col(static_cast<Eigen::Index>(s)) =
        points.col(nearest[s]).template cast<double>() + origin;
    samples.farthest_put_back = std::max(samples.farthest_put_back, std::sqrt(least[s]));
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
VolumeSamples sample_volume(const DensityGrid& density, Index sites, const VolumeOptions& options) {
  options.validate();
  const Index count = checked_point_count(sites, options.points_per_site);
  detail::check_density(density, count, Eigen::Dynamic, sizeof(double));
  const LocalDensity local = around_middle(density);
  const auto points =
      sample_local_density<Scalar>(local, count, options.tessellation.seed, options.sampling,
                                   options.tessellation.threads, options.tessellation.cancelled);
  Solver<Scalar> solver(Problem<Scalar>(points, sites), options.tessellation);
  solver.run();
  const Points<Scalar> centroids = solver.sites();
  std::vector<Index> owners = solver.owners();

  VolumeSamples samples;
  samples.scalar = sizeof(Scalar) == sizeof(float) ? ScalarType::float32 : ScalarType::float64;
  samples.summary = solver.summary();
  samples.sites = centroids.template cast<double>().colwise() + local.origin;
  measure_cells(points, centroids, owners, samples);
  weigh_cells(density, Arena(options.tessellation.threads), samples);
  put_back(density, points, local.origin, owners, samples);
  if (options.keep_points) {
    samples.points = points.template cast<double>().colwise() + local.origin;
    samples.owners = std::move(owners);
  }
  return samples;
}

template CCVT_EXPORT VolumeSamples sample_volume<float>(const DensityGrid&, Index,
                                                        const VolumeOptions&);
template CCVT_EXPORT VolumeSamples sample_volume<double>(const DensityGrid&, Index,
                                                         const VolumeOptions&);

}  // namespace ccvt
