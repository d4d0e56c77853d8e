#include "ccvt/density.h"

#include <Eigen/LU>
#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>
#include <numeric>
#include <string>

#include "checks.h"
#include "number_text.h"
#include "parallel/arena.h"
#include "parallel/together.h"
#include "point_count.h"
#include "sampling/cell_densities.h"
#include "sampling/density_mass.h"
#include "sampling/density_parts.h"
#include "sampling/draw_parts.h"
#include "sampling/grid_world.h"
#include "sampling/mass.h"
#include "thread_count.h"

namespace ccvt {
namespace {

void check_shape(const DensityGrid& grid) {
  if (std::ssize(grid.shape) != grid.box.dimension()) {
    throw InvalidInput(concat("grid: shape has ", grid.shape.size(),
                              " dimensions, but the box has ", grid.box.dimension()));
  }
  std::int64_t cells = 1;
  for (std::size_t d = 0; d < grid.shape.size(); ++d) {
    if (grid.shape[d] < 1) {
      throw InvalidInput(
          concat("grid: shape[", d, "] is ", grid.shape[d], ", but must be at least 1"));
    }
    if (grid.shape[d] > std::numeric_limits<std::int64_t>::max() / cells) {
      throw InvalidInput(concat("grid: shape ", std::span(grid.shape), " has 2^63 cells or more"));
    }
    cells *= grid.shape[d];
  }
}

std::int64_t values_of(const DensityGrid& grid) {
  return std::visit([](const auto& values) { return std::ssize(values); }, grid.values);
}

std::int64_t cells_of(const DensityGrid& grid) {
  return std::accumulate(grid.shape.begin(), grid.shape.end(), std::int64_t{1},
                         std::multiplies<>());
}

/// `what` has so many cells: values and mask must have as many.
void check_cells(const DensityGrid& grid, const std::string& what, std::int64_t cells) {
  if (cells != values_of(grid)) {
    throw InvalidInput(
        concat(what, " has ", cells, " cells, but there are ", values_of(grid), " values"));
  }
  if (!grid.mask.empty() && std::ssize(grid.mask) != cells) {
    throw InvalidInput(
        concat(what, " has ", cells, " cells, but the mask has ", grid.mask.size(), " entries"));
  }
}

void check_affine(const DensityGrid& grid) {
  if (!grid.to_world) return;
  const Affine& map = *grid.to_world;
  const Eigen::Index dimension = grid.box.dimension();
  if (map.matrix.rows() != dimension || map.matrix.cols() != dimension ||
      map.offset.size() != dimension) {
    throw InvalidInput(concat("grid: to_world has a matrix of ", map.matrix.rows(), " x ",
                              map.matrix.cols(), " and an offset of ", map.offset.size(),
                              ", but the box has ", dimension, " dimensions"));
  }
  const double volume = map.matrix.eigen().determinant();
  if (!map.offset.eigen().allFinite() || !std::isfinite(volume) || volume == 0) {
    throw InvalidInput(
        concat("grid: to_world must be finite and not singular; its determinant is ", volume));
  }
}

void check_places(const DensityGrid& grid, std::int64_t count, int fixed_dimension,
                  std::size_t scalar_bytes) {
  detail::check_sampling(grid.box, count, fixed_dimension, scalar_bytes);
  require_enumerator("grid: interpolation", grid.interpolation, Interpolation::linear);
  check_affine(grid);
  detail::check_sampling(world_box(grid), count, fixed_dimension, scalar_bytes);
  check_shape(grid);
}

template <class Scalar>
void fill(const DensityGrid& grid, const Eigen::VectorXd& origin, std::uint64_t seed,
          DensitySampling sampling, int threads, std::span<Scalar> coordinates,
          const std::function<bool()>& cancelled) try {
  require_threads(threads);
  require_enumerator("sampling", sampling, DensitySampling::stratified);
  Stop stop(cancelled);
  const Arena arena(threads, &stop);
  const CellDensities densities(grid);
  const DensityParts parts(grid.shape);
  const std::vector<double> masses = parts.masses(grid, densities, arena, nullptr);
  const std::int64_t count = std::ssize(coordinates) / std::ssize(grid.shape);
  DrawParts<Scalar> draw(grid, origin, densities, parts, seed, sampling, arena);
  const auto place = [&](std::size_t part, int worker, std::int64_t first,
                         std::span<const double> targets) {
    draw(part, worker, targets, coordinates.data() + first * std::ssize(grid.shape));
  };
  if (sampling == DensitySampling::stratified) {
    deal(masses, StratifiedDraws(seed, count), arena, place);
  } else {
    deal(masses, SortedDraws(seed, count, arena), arena, place);
  }
} catch (const Stopped&) {
  throw Cancelled();
}

}  // namespace

double density_mass(const DensityGrid& grid, const Arena& arena) {
  return integral(grid, DensityParts(grid.shape).masses(grid, CellDensities(grid), arena, nullptr));
}

double integral(const DensityGrid& grid, std::span<const double> masses) {
  GroupedSum sum;
  for (const double mass : masses) sum.add(mass);
  const double cells = cells_along(grid).prod();
  const double stretch = grid.to_world ? std::abs(grid.to_world->matrix.eigen().determinant()) : 1;
  return sum.value() * (grid.box.volume() / cells * stretch);
}

template <class Scalar>
Points<Scalar> sample_local_density(const LocalDensity& local, Index count, std::uint64_t seed,
                                    DensitySampling sampling, int threads,
                                    const std::function<bool()>& cancelled) {
  detail::check_density(local.grid, count, Eigen::Dynamic, sizeof(Scalar));
  Points<Scalar> points(local.grid.box.dimension(), count);
  fill(local.grid, local.origin, seed, sampling, threads,
       std::span<Scalar>(points.data(), points.data() + points.size()), cancelled);
  return points;
}

template Points<float> sample_local_density(const LocalDensity&, Index, std::uint64_t,
                                            DensitySampling, int, const std::function<bool()>&);
template Points<double> sample_local_density(const LocalDensity&, Index, std::uint64_t,
                                             DensitySampling, int, const std::function<bool()>&);

namespace detail {

void check_density(const DensityGrid& grid, Index count, int fixed_dimension,
                   std::size_t scalar_bytes) {
  check_places(grid, count, fixed_dimension, scalar_bytes);
  check_cells(grid, concat("grid: shape ", std::span(grid.shape)), cells_of(grid));
}

void check_density(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                   std::size_t scalar_bytes) {
  agree(&ranks, [&] {
    const DensityGrid& grid = density.grid;
    check_places(grid, count, Eigen::Dynamic, scalar_bytes);
    if (count > most_points(ranks)) {
      throw InvalidInput(concat("count: is ", count, ", but ", ranks.count(),
                                " ranks have at most ", most_points(ranks), " points"));
    }
    const GridLayers layers(grid.shape, level_of_parts(grid.shape));
    const LayerRange needed = layers.around(ranks.rank(), ranks.count());
    const auto& [begin, end] = density.layers;
    if (begin != needed.begin || end != needed.end) {
      throw InvalidInput(concat("layers: rank ", ranks.rank(), " of ", ranks.count(), " has ",
                                begin, " to ", end, ", but needs ", needed.begin, " to ",
                                needed.end, ", as layers_of_rank() says"));
    }
    check_cells(grid, concat("layers: ", begin, " to ", end, " of shape ", std::span(grid.shape)),
                (end - begin) * layers.cells);
  });
}

void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                  int threads, std::span<float> coordinates,
                  const std::function<bool()>& cancelled) {
  fill(grid, Eigen::VectorXd::Zero(grid.box.dimension()), seed, sampling, threads, coordinates,
       cancelled);
}

void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                  int threads, std::span<double> coordinates,
                  const std::function<bool()>& cancelled) {
  fill(grid, Eigen::VectorXd::Zero(grid.box.dimension()), seed, sampling, threads, coordinates,
       cancelled);
}

}  // namespace detail
}  // namespace ccvt
