#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "numbers.h"
#include "parallel/loops.h"
#include "point_count.h"
#include "put_back.h"
#include "sampling/cell_densities.h"
#include "sampling/density_mass.h"
#include "sampling/grid_world.h"

namespace ccvt {

namespace {

/// Capacities and radii, from the points of each cell: in the order of the points, part by part.
template <class Scalar>
void measure_cells(PointsView<Scalar> points, PointsView<Scalar> sites,
                   const std::vector<Index>& owners, const Arena& arena, VolumeSamples& samples) {
  constexpr std::size_t kSitesPerGrain = 256;
  const auto count = static_cast<std::size_t>(sites.count);
  const std::size_t at_once = std::max(count, std::size_t{1} << 22);
  std::vector<double> squared(count);
  samples.capacities.assign(count, 0);
  for (std::size_t begin = 0; begin < owners.size(); begin += at_once) {
    const auto by_owner = group_by_key<PointNumber>(
        arena, std::min(at_once, owners.size() - begin), count,
        [&](std::size_t k) { return PointNumber(begin + k); },
        [&](PointNumber p) { return std::size_t{SiteNumber(owners[p])}; });
    arena.for_each(count, kSitesPerGrain, [&](std::size_t s) {
      const Scalar* const site = sites[SiteNumber(s).index()];
      for (const PointNumber p : by_owner[s]) {
        ++samples.capacities[s];
        const Scalar* const point = points[p.index()];
        for (int d = 0; d < points.dimension; ++d) {
          const double at = point[d];
          const double difference = at - site[d];
          squared[s] += difference * difference;
        }
      }
    });
  }
  const double dimension = points.dimension;
  samples.radii.resize(count);
  for (std::size_t s = 0; s < count; ++s) {
    samples.radii[s] = std::sqrt((dimension + 2) / dimension * squared[s] / samples.capacities[s]);
  }
}

/// Every site's share of the integral of the density.
void weigh_cells(const DensityGrid& density, const Arena& arena, VolumeSamples& samples) {
  const double mass = density_mass(density, arena);
  double owned = 0;
  for (const Index capacity : samples.capacities) owned += capacity;
  for (const Index capacity : samples.capacities) {
    samples.weights.push_back(mass * capacity / owned);
  }
}

/// Moves sites that are where the density is 0 to the nearest of their points. `points` are
/// relative to `origin`.
template <class Scalar>
void put_back(const DensityGrid& density, const Points<Scalar>& points,
              const Eigen::VectorXd& origin, const std::vector<Index>& owners, const Arena& arena,
              VolumeSamples& samples) {
  const CellDensities densities(density);
  const CellLocator cell_of(density);
  const auto in_world = [&](PointNumber p) -> Eigen::VectorXd {
    return points.col(p.index()).template cast<double>() + origin;
  };
  const PutBack moved = put_back_sites(
      owners, samples.capacities.size(), arena,
      [&](SiteNumber s) { return !(densities(cell_of(samples.sites.col(s.index()).data())) > 0); },
      [&](PointNumber p, SiteNumber s) {
        return (in_world(p) - samples.sites.col(s.index())).squaredNorm();
      },
      [&](SiteNumber s, PointNumber p) { samples.sites.eigen().col(s.index()) = in_world(p); });
  samples.put_back = moved.sites;
  samples.farthest_put_back = moved.farthest;
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
  const int threads = options.tessellation.threads;
  Solver<Scalar> solver(Problem<Scalar>(points, sites, threads), options.tessellation);
  solver.run();
  const Points<Scalar> centroids = solver.sites();
  std::vector<Index> owners = solver.owners();

  VolumeSamples samples;
  samples.scalar = sizeof(Scalar) == sizeof(float) ? ScalarType::float32 : ScalarType::float64;
  samples.summary = solver.summary();
  samples.sites = centroids.template cast<double>().colwise() + local.origin;
  const Arena arena(threads);
  measure_cells(view_points(points), view_points(centroids), owners, arena, samples);
  weigh_cells(density, arena, samples);
  put_back(density, points, local.origin, owners, arena, samples);
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
