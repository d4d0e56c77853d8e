#include <string>
#include <utility>
#include <vector>

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
#include "volume/sample_parts.h"

namespace ccvt {

namespace {

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
  std::vector<Index> owners = solver.owners();

  const Arena arena(threads);
  VolumeSamples samples = samples_of(solver, view_points(points), owners, local, arena);
  weigh_cells(density_mass(density, arena), samples);
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
