// Samples of a density of which each of several ranks has some layers.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "ccvt/volume.h"
#include "numbers.h"
#include "parallel/bytes.h"
#include "parallel/together.h"
#include "point_count.h"
#include "put_back.h"
#include "sampling/cell_densities.h"
#include "sampling/density_mass.h"
#include "sampling/density_parts.h"
#include "sampling/grid_world.h"
#include "volume/mask_entries.h"
#include "volume/sample_parts.h"

namespace ccvt {
namespace {

/// Which sites are where the density is 0: 1 for these. Each rank looks at those in its layers.
std::vector<std::uint8_t> sites_outside(Ranks& ranks, const DensityLayers& density,
                                        const Columns<double>& sites) {
  const GridLayers layers(density.grid.shape, level_of_parts(density.grid.shape));
  const LayerRange own = layers.of(ranks.rank(), ranks.count());
  const CellDensities densities(density.grid, density.layers.begin * layers.cells);
  const CellLocator cell_of(density.grid);
  std::vector<SiteNumber> outside;
  for (const SiteNumber s : sites_below(static_cast<std::size_t>(sites.cols()))) {
    const std::int64_t cell = cell_of(sites.eigen().col(s.index()).data());
    const std::int64_t layer = cell / layers.cells;
    if (layer >= own.begin && layer < own.end && !(densities(cell) > 0)) outside.push_back(s);
  }
  std::vector<std::uint8_t> marks(static_cast<std::size_t>(sites.cols()), 0);
  for (const SiteNumber s : joined(&ranks, std::move(outside))) marks[s] = 1;
  return marks;
}

/// Moves sites that are where the density is 0 to the nearest of their points on all ranks: of
/// several, to the first. `points` are this rank's, relative to `origin`.
template <class Scalar>
void put_back(Ranks& ranks, const DensityLayers& density, const Points<Scalar>& points,
              const Eigen::VectorXd& origin, const std::vector<Index>& owners, const Arena& arena,
              VolumeSamples& samples) {
  const std::vector<std::uint8_t> outside = sites_outside(ranks, density, samples.sites);
  const auto in_world = [&](PointNumber p) -> Eigen::VectorXd {
    return points.col(p.index()).template cast<double>() + origin;
  };
  const auto squared_distance = [&](PointNumber p, SiteNumber s) {
    return (in_world(p) - samples.sites.eigen().col(s.index())).squaredNorm();
  };
  ByteWriter nearest;
  put_back_sites(
      owners, outside.size(), arena, [&](SiteNumber s) { return outside[s] != 0; },
      squared_distance,
      [&](SiteNumber s, PointNumber p) {
        const Eigen::VectorXd place = in_world(p);
        nearest.put(s);
        nearest.put(squared_distance(p, s));
        nearest.put(std::span(place.data(), static_cast<std::size_t>(place.size())));
      });
  std::vector<double> least(outside.size(), std::numeric_limits<double>::infinity());
  Eigen::VectorXd place(origin.size());
  for (const Ranks::Bytes& bytes : ranks.gather(nearest.bytes)) {
    ByteReader found(bytes);
    while (!found.done()) {
      const auto s = found.get<SiteNumber>();
      const auto squared = found.get<double>();
      found.get(std::span(place.data(), static_cast<std::size_t>(place.size())));
      if (!(squared < least[s])) continue;
      least[s] = squared;
      samples.sites.eigen().col(s.index()) = place;
    }
  }
  for (const double squared : least) {
    if (std::isinf(squared)) continue;
    ++samples.put_back;
    samples.farthest_put_back = std::max(samples.farthest_put_back, std::sqrt(squared));
  }
}

}  // namespace

template <class Scalar>
VolumeSamples sample_volume(Ranks& ranks, const DensityLayers& density, Index sites,
                            const VolumeOptions& options) {
  std::int64_t count = 0;
  agree(&ranks, [&] {
    options.validate();
    count = checked_point_count(sites, options.points_per_site, most_points(ranks));
  });
  detail::check_density(ranks, density, count, sizeof(double));
  const LocalDensity local = around_middle(density.grid);
  const int threads = options.tessellation.threads;
  const auto points = sample_local_density<Scalar>(
      ranks, local, density.layers, count, options.tessellation.seed, options.sampling, threads);
  Solver<Scalar> solver(Problem<Scalar>(ranks, view_points(points), sites, threads),
                        options.tessellation);
  solver.run();
  std::vector<Index> owners = solver.owners();

  const Arena arena(threads);
  VolumeSamples samples = samples_of(solver, view_points(points), owners, local, arena, &ranks);
  weigh_cells(density_mass(ranks, density, arena), samples);
  put_back(ranks, density, points, local.origin, owners, arena, samples);
  if (options.keep_points) {
    samples.points = points.template cast<double>().colwise() + local.origin;
    samples.owners = std::move(owners);
  }
  return samples;
}

template CCVT_EXPORT VolumeSamples sample_volume<float>(Ranks&, const DensityLayers&, Index,
                                                        const VolumeOptions&);
template CCVT_EXPORT VolumeSamples sample_volume<double>(Ranks&, const DensityLayers&, Index,
                                                         const VolumeOptions&);

DensityLayers density_layers(Ranks& ranks, const VolumeHeader& whole, const Volume& part,
                             const ValueMap& map, MaskView mask) {
  const LayerRange layers = layers_of_rank(whole.grid.shape, ranks.rank(), ranks.count());
  double greatest = -std::numeric_limits<double>::infinity();
  agree(&ranks, [&] {
    map.validate();
    require_entries(part, mask);
    if (part.type != whole.type || part.slope != whole.slope || part.intercept != whole.intercept) {
      throw InvalidInput("part: its numbers are not of the volume's type and scale");
    }
    const bool counts = mask.empty() ? part.cells() > 0
                                     : std::any_of(mask.begin(), mask.end(),
                                                   [](std::uint8_t entry) { return entry != 0; });
    if (map.needs_greatest() && counts) greatest = part.greatest(mask);
  });
  for (const double own : of_all(&ranks, greatest)) greatest = std::max(greatest, own);
  DensityLayers result;
  agree(&ranks, [&] { result.grid = part.density(map, greatest, mask); });
  const DensityGrid place = whole.grid.density(result.grid.values, result.grid.interpolation);
  result.grid.shape = place.shape;
  result.grid.box = place.box;
  result.grid.to_world = place.to_world;
  result.layers = layers;
  return result;
}

}  // namespace ccvt
