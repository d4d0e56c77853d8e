#include "ccvt/density.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "number_text.h"
#include "parallel/arena.h"
#include "parallel/loops.h"
#include "random.h"
#include "sampling/cell_densities.h"
#include "sampling/cell_fill.h"
#include "sampling/density_mass.h"
#include "sampling/grid_world.h"
#include "sampling/hilbert.h"
#include "sampling/mass.h"
#include "streams.h"
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
  const std::int64_t values = std::visit([](const auto& v) { return std::ssize(v); }, grid.values);
  if (cells != values) {
    throw InvalidInput(concat("grid: shape ", std::span(grid.shape), " has ", cells,
                              " cells, but there are ", values, " values"));
  }
  if (!grid.mask.empty() && std::ssize(grid.mask) != values) {
    throw InvalidInput(concat("grid: shape ", std::span(grid.shape), " has ", cells,
                              " cells, but the mask has ", grid.mask.size(), " entries"));
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

bool is_density(double value) { return value >= 0 && value <= std::numeric_limits<double>::max(); }

[[noreturn]] void refuse_density(const DensityGrid& grid, const CellDensities& densities,
                                 std::int64_t cell) {
  std::vector<std::int64_t> position(grid.shape.size());
  cell_position(cell, grid.shape, position);
  const std::string mapped =
      grid.map ? concat(", and its density ", densities(cell)) : std::string();
  throw InvalidInput(concat("grid: values[", cell, "], cell ", std::span(position),
                            " (fastest axis first), is ", densities.value(cell), mapped,
                            ", but must be finite and not negative"));
}

// The curve through the cells, cut into parts that are worked on by themselves.
struct Parts {
  HilbertCurve curve;
  int level = 0;
  std::vector<HilbertCurve::Part> parts;

  // Parts of up to 4096 cells, and fewer where there would be less than a thousand parts.
  explicit Parts(const DensityGrid& grid, std::int64_t cells) : curve(grid.shape) {
    const auto axes =
        std::count_if(grid.shape.begin(), grid.shape.end(), [](std::int64_t n) { return n > 1; });
    const std::int64_t most = std::clamp<std::int64_t>(cells / 1024, 1, 4096);
    while (axes > 0 && (level + 1) * axes < 62 &&
           (std::int64_t{1} << ((level + 1) * axes)) <= most) {
      ++level;
    }
    if (level == 0 && cells > 65'536) level = 1;
    parts = curve.parts(level);
  }
};

// The first cell, if any, whose density is refused.
struct Refused {
  static constexpr std::int64_t none = std::numeric_limits<std::int64_t>::max();
  std::int64_t cell = none;

  void add(std::int64_t other) { cell = std::min(cell, other); }
};

// The mass of each part.
std::vector<double> masses_of(const DensityGrid& grid, const CellDensities& densities,
                              const Parts& parts, const Arena& arena) {
  std::vector<double> masses(parts.parts.size());
  PerWorker<Refused> refused(arena);
  arena.for_ranges(masses.size(), 64, [&](std::size_t begin, std::size_t end, int worker) {
    HilbertCurve curve = parts.curve;
    for (std::size_t p = begin; p < end; ++p) {
      double sum = 0;
      curve.visit_rows(parts.parts[p], parts.level, [&](std::int64_t first, std::int64_t count) {
        double row = 0;
        densities.visit_row(first, count, [&](std::int64_t cell, double density) {
          if (!is_density(density)) refused[worker].add(cell);
          row += density;
        });
        sum += row;
      });
      masses[p] = sum;
    }
  });
  Refused first;
  for (int worker = 0; worker < arena.threads(); ++worker) first.add(refused[worker].cell);
  if (first.cell != Refused::none) refuse_density(grid, densities, first.cell);
  GroupedSum total;
  for (const double mass : masses) total.add(mass);
  if (total.value() == 0) {
    const std::size_t values = std::visit([](const auto& v) { return v.size(); }, grid.values);
    const char* const what = grid.map || !grid.mask.empty() ? " densities are 0" : " values are 0";
    throw InvalidInput(concat("grid: all ", values, what));
  }
  if (!std::isfinite(total.value())) throw InvalidInput("grid: the sum of the values overflows");
  return masses;
}

template <class Scalar>
void fill(const DensityGrid& grid, const Eigen::VectorXd& origin, std::uint64_t seed,
          DensitySampling sampling, int threads, std::span<Scalar> coordinates,
          const std::function<bool()>& cancelled) try {
  require_threads(threads);
  Stop stop(cancelled);
  const Arena arena(threads, &stop);
  const CellDensities densities(grid);
  const Parts parts(grid, std::visit([](const auto& v) { return std::ssize(v); }, grid.values));
  const std::vector<double> masses = masses_of(grid, densities, parts, arena);

  const bool stratified = sampling == DensitySampling::stratified;
  const auto count = static_cast<Index>(coordinates.size() / grid.shape.size());
  struct Tools {
    CellFill<Scalar> fill;
    HilbertCurve curve;
  };
  PerWorker<std::optional<Tools>> tools(arena);
  const auto place = [&](std::size_t part, int worker, Index first,
                         std::span<const double> targets) {
    auto& own = tools[worker];
    if (!own) own.emplace(Tools{{grid, densities, origin, stratified}, parts.curve});
    Random random(seed, streams::density_place + part);
    Scalar* out = coordinates.data() + first * std::ssize(grid.shape);
    const auto along_curve = [&](const auto& f) {
      own->curve.visit(parts.parts[part], parts.level,
                       [&](std::int64_t cell) { f(cell, densities(cell)); });
    };
    deal_to_cells(targets, along_curve,
                  [&](std::int64_t cell, Index hits) { out = own->fill(cell, hits, random, out); });
  };
  if (stratified) {
    deal(masses, StratifiedDraws(seed, count), arena, place);
  } else {
    deal(masses, SortedDraws(seed, count, arena), arena, place);
  }
} catch (const Stopped&) {
  throw Cancelled();
}

}  // namespace

double density_mass(const DensityGrid& grid, const Arena& arena) {
  const std::int64_t cells =
      std::visit([](const auto& values) { return std::ssize(values); }, grid.values);
  GroupedSum sum;
  for (const double mass : masses_of(grid, CellDensities(grid), Parts(grid, cells), arena)) {
    sum.add(mass);
  }
  const double stretch = grid.to_world ? std::abs(grid.to_world->matrix.eigen().determinant()) : 1;
  return sum.value() * (grid.box.volume() / static_cast<double>(cells) * stretch);
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
  check_sampling(grid.box, count, fixed_dimension, scalar_bytes);
  check_affine(grid);
  check_sampling(world_box(grid), count, fixed_dimension, scalar_bytes);
  check_shape(grid);
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
