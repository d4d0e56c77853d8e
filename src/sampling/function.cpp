#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <vector>

#include "ccvt/density.h"
#include "checks.h"
#include "number_text.h"
#include "parallel/arena.h"
#include "random.h"
#include "sampling/hilbert.h"
#include "sampling/mass.h"
#include "sampling/scalar_box.h"
#include "streams.h"
#include "thread_count.h"

namespace ccvt {
namespace {

constexpr std::int64_t most_tries = 10'000'000;
constexpr double least_cells = 65'536;

// The function, checked, at points rounded to Scalar: those that are given out.
template <class Scalar>
class CheckedDensity {
 public:
  CheckedDensity(const DensityFunction& density, double maximum, const Box& box)
      : density_(density), maximum_(maximum), bounds_(box), point_(bounds_.dimension()) {
    if (!density) throw InvalidInput("density: is empty, but must be callable");
    if (!(maximum > 0 && std::isfinite(maximum))) {
      throw InvalidInput(concat("maximum: is ", maximum, ", but must be positive and finite"));
    }
  }

  [[nodiscard]] std::size_t dimension() const { return point_.size(); }

  /// The density at a uniform draw from a cell.
  double draw(Random& random, const double* corner, const double* size) {
    for (std::size_t d = 0; d < point_.size(); ++d) {
      point_[d] = bounds_.round(d, corner[d] + random.uniform() * size[d]);
    }
    const double value = density_(point_);
    if (value >= 0 && value <= maximum_) return value;
    throw InvalidInput(concat("density: is ", value, " at ", std::span<const double>(point_),
                              ", but must be from 0 up to maximum, ", maximum_));
  }

  /// Draws from a cell until one is accepted, and stores it.
  Scalar* accept(Random& random, const double* corner, const double* size, Scalar* out) {
    for (std::int64_t tries = 0; tries < most_tries; ++tries) {
      const double value = draw(random, corner, size);
      const double threshold = random.uniform() * maximum_;
      if (threshold < value) return std::copy(point_.begin(), point_.end(), out);
    }
    throw InvalidInput(concat(
        "density: ", most_tries, " candidates in a row were refused, the last ",
        std::span<const double>(point_), ": it is zero or very small against maximum, ", maximum_));
  }

 private:
  const DensityFunction& density_;
  double maximum_;
  ScalarBox<Scalar> bounds_;
  std::vector<double> point_;  // exact in Scalar
};

// At least `cells` nearly cubic cells that fill a box.
class Grid {
 public:
  Grid(const Box& box, double cells) : lower_(box.lower.begin(), box.lower.end()) {
    const Eigen::VectorXd extent = box.extent();
    size_.assign(extent.begin(), extent.end());
    shape_.assign(size_.size(), 1);
    std::vector<std::size_t> order(size_.size());  // by extent, ascending
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return size_[a] < size_[b]; });
    double log_volume = extent.array().log().sum();
    double left = cells;
    double remaining = box.dimension();
    for (const std::size_t d : order) {
      const double log_side = std::log(size_[d]);
      const double ideal =
          std::exp(log_side + (std::log(std::max(left, 1.0)) - log_volume) / remaining);
      log_volume -= log_side;
      // Up for the last one; elsewhere to the nearest, with room for the C library's last bits.
      const double nearest =
          remaining == 1 ? std::ceil(left - 1e-9) : std::floor(ideal + 0.5 + 1e-9);
      const double parts = std::max(nearest, 1.0);
      shape_[d] = static_cast<std::int64_t>(parts);
      size_[d] /= parts;
      left /= parts;
      --remaining;
    }
  }

  [[nodiscard]] std::span<const std::int64_t> shape() const { return shape_; }
  [[nodiscard]] std::size_t dimension() const { return shape_.size(); }
  [[nodiscard]] const double* size() const { return size_.data(); }
  [[nodiscard]] std::size_t cells() const {
    return std::accumulate(shape_.begin(), shape_.end(), std::size_t{1},
                           std::multiplies<std::size_t>());
  }
  void corner(std::int64_t cell, std::vector<double>& corner) const {
    for (std::size_t d = 0; d < shape_.size(); ++d) {
      corner[d] = lower_[d] + static_cast<double>(cell % shape_[d]) * size_[d];
      cell /= shape_[d];
    }
  }

 private:
  std::vector<double> lower_;
  std::vector<double> size_;
  std::vector<std::int64_t> shape_;
};

constexpr std::size_t chunk = 4096;  // cells or points that share a random stream

// The density at one uniform draw from each cell of a grid: an unbiased estimate of its mean there.
// With the sum of each chunk of cells along a Hilbert curve, which is their order.
template <class Scalar>
class Table {
 public:
  Table(const CheckedDensity<Scalar>& density, const Grid& grid, std::uint64_t seed,
        const Arena& arena)
      : cells(grid.cells()), values(cells.size()) {
    std::size_t next = 0;
    HilbertCurve(grid.shape()).visit([&](std::int64_t cell) { cells[next++] = cell; });
    sums.resize((cells.size() + chunk - 1) / chunk);
    arena.for_each(sums.size(), 1, [&](std::size_t c) {
      CheckedDensity<Scalar> drawn = density;
      Random random(seed, streams::function_tabulate + c);
      std::vector<double> corner(grid.dimension());
      for (std::size_t k = c * chunk; k < std::min((c + 1) * chunk, cells.size()); ++k) {
        grid.corner(cells[k], corner);
        values[k] = drawn.draw(random, corner.data(), grid.size());
        sums[c] += values[k];
      }
    });
  }

  [[nodiscard]] double total() const {
    GroupedSum sum;
    for (const double part : sums) sum.add(part);
    return sum.value();
  }

  std::vector<std::int64_t> cells;
  std::vector<double> values;
  std::vector<double> sums;
};

template <class Scalar>
void stratified(const CheckedDensity<Scalar>& density, double maximum, const Box& box, Index count,
                std::uint64_t seed, const Arena& arena, Scalar* points) {
  Grid grid(box, std::max(4.0 * count, least_cells));
  Table<Scalar> table(density, grid, seed, arena);
  // More cells where the density is concentrated, so that few get several points.
  const auto cells = static_cast<double>(grid.cells());
  const double mean = table.total() / cells;
  const double wanted = count * std::min(16.0, maximum / mean);
  if (wanted > 1.5 * cells || table.total() == 0) {
    grid = Grid(box, std::max(16.0 * count, 16 * least_cells));
    table = Table<Scalar>(density, grid, seed, arena);
  }
  if (table.total() == 0) {
    throw InvalidInput(concat("density: is 0 at all of ", grid.cells(), " candidates"));
  }
  if (!std::isfinite(table.total())) {
    throw InvalidInput("density: the sum over candidates overflows");
  }

  deal(table.sums, StratifiedDraws(seed, count), arena,
       [&](std::size_t c, int, std::int64_t first, std::span<const double> targets) {
         CheckedDensity<Scalar> drawn = density;
         Random random(seed, streams::density_place + c);
         std::vector<double> corner(grid.dimension());
         Scalar* out = points + first * box.lower.size();
         const auto in_order = [&](const auto& f) {
           for (std::size_t k = c * chunk; k < std::min((c + 1) * chunk, table.cells.size()); ++k) {
             f(table.cells[k], table.values[k]);
           }
         };
         deal_to_cells(targets, in_order, [&](std::int64_t cell, std::int64_t hits) {
           grid.corner(cell, corner);
           for (std::int64_t k = 0; k < hits; ++k) {
             out = drawn.accept(random, corner.data(), grid.size(), out);
           }
         });
       });
}

template <class Scalar>
void fill(const DensityFunction& f, double maximum, const Box& box, std::uint64_t seed,
          DensitySampling sampling, int threads, std::span<Scalar> coordinates,
          const std::function<bool()>& cancelled) try {
  require_threads(threads);
  require_enumerator("sampling", sampling, DensitySampling::stratified);
  Stop stop(cancelled);
  const Arena arena(threads, &stop);
  const CheckedDensity<Scalar> density(f, maximum, box);
  const std::size_t dimension = density.dimension();
  const std::size_t count = coordinates.size() / dimension;
  if (sampling == DensitySampling::stratified) {
    stratified(density, maximum, box, static_cast<Index>(count), seed, arena, coordinates.data());
    return;
  }
  const Eigen::VectorXd extent = box.extent();
  arena.for_each((count + chunk - 1) / chunk, 1, [&](std::size_t c) {
    CheckedDensity<Scalar> drawn = density;
    Random random(seed, streams::density_place + c);
    Scalar* out = coordinates.data() + c * chunk * dimension;
    for (std::size_t k = c * chunk; k < std::min((c + 1) * chunk, count); ++k) {
      out = drawn.accept(random, box.lower.data(), extent.data(), out);
    }
  });
} catch (const Stopped&) {
  throw Cancelled();
}

}  // namespace

namespace detail {

void fill_function(const DensityFunction& density, double maximum, const Box& box,
                   std::uint64_t seed, DensitySampling sampling, int threads,
                   std::span<float> coordinates, const std::function<bool()>& cancelled) {
  fill(density, maximum, box, seed, sampling, threads, coordinates, cancelled);
}

void fill_function(const DensityFunction& density, double maximum, const Box& box,
                   std::uint64_t seed, DensitySampling sampling, int threads,
                   std::span<double> coordinates, const std::function<bool()>& cancelled) {
  fill(density, maximum, box, seed, sampling, threads, coordinates, cancelled);
}

}  // namespace detail
}  // namespace ccvt
