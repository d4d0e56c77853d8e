#include "ccvt/density.h"

#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "random.h"
#include "sampling/hilbert.h"
#include "sampling/mass.h"
#include "sampling/scalar_box.h"
#include "sampling/strata.h"
#include "sampling/streams.h"
#include "sampling/text.h"

namespace ccvt {
namespace {

void check_shape(const DensityGrid& grid, std::size_t values) {
  if (grid.shape.size() != static_cast<std::size_t>(grid.box.dimension())) {
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
  if (static_cast<std::size_t>(cells) != values) {
    throw InvalidInput(concat("grid: shape ", std::span(grid.shape), " has ", cells,
                              " cells, but there are ", values, " values"));
  }
}

// Index of a cell along each dimension.
void cell_position(std::int64_t cell, std::span<const std::int64_t> shape,
                   std::span<std::int64_t> position) {
  for (std::size_t d = 0; d < shape.size(); ++d) {
    position[d] = cell % shape[d];
    cell /= shape[d];
  }
}

// The sum of the values.
template <class Value>
double check_values(const DensityGrid& grid, std::span<const Value> values) {
  GroupedSum sum;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!(values[i] >= 0 && values[i] <= std::numeric_limits<Value>::max())) {
      std::vector<std::int64_t> position(grid.shape.size());
      cell_position(static_cast<std::int64_t>(i), grid.shape, position);
      throw InvalidInput(concat("grid: values[", i, "], cell ", std::span(position), ", is ",
                                values[i], ", but must be finite and not negative"));
    }
    sum.add(static_cast<double>(values[i]));
  }
  const double total = sum.value();
  if (total == 0) throw InvalidInput(concat("grid: all ", values.size(), " values are 0"));
  if (!std::isfinite(total)) throw InvalidInput("grid: the sum of the values overflows");
  return total;
}

// Puts points uniformly into cells of a grid, one behind the other in memory.
template <class Scalar>
class CellFill {
 public:
  CellFill(const DensityGrid& grid, std::uint64_t seed, bool jittered, Scalar* out)
      : grid_(grid),
        bounds_(grid.box),
        random_(seed, streams::density_place),
        jittered_(jittered),
        out_(out),
        position_(grid.shape.size()),
        corner_(grid.box.lower),
        size_(grid.box.extent()) {
    for (Eigen::Index d = 0; d < size_.size(); ++d) {
      size_[d] /= static_cast<double>(grid.shape[static_cast<std::size_t>(d)]);
    }
  }

  void operator()(std::int64_t cell, Index hits) {
    cell_position(cell, grid_.shape, position_);
    for (Eigen::Index d = 0; d < size_.size(); ++d) {
      const auto i = static_cast<double>(position_[static_cast<std::size_t>(d)]);
      corner_[d] = grid_.box.lower[d] + i * size_[d];
    }
    const auto dimension = static_cast<std::size_t>(size_.size());
    if (hits == 1 || !jittered_) {
      for (Index k = 0; k < hits; ++k) {
        put(std::span<const double>(corner_.data(), dimension),
            std::span<const double>(size_.data(), dimension));
      }
      return;
    }
    strata(hits).visit(corner_, 0, hits,
                       [&](Index, std::span<const double> corner, std::span<const double> size) {
                         put(corner, size);
                       });
  }

 private:
  void put(std::span<const double> corner, std::span<const double> size) {
    for (std::size_t d = 0; d < corner.size(); ++d) {
      *out_++ = bounds_.round(d, corner[d] + random_.uniform() * size[d]);
    }
  }

  // All cells have the same shape, and adjacent ones similar numbers of points.
  const Strata& strata(Index hits) {
    auto& strata = strata_[static_cast<std::size_t>(hits) % strata_.size()];
    if (!strata || strata->count() != hits) strata.emplace(size_, hits);
    return *strata;
  }

  const DensityGrid& grid_;
  ScalarBox<Scalar> bounds_;
  Random random_;
  bool jittered_;
  Scalar* out_;
  std::vector<std::int64_t> position_;
  Eigen::VectorXd corner_;
  Eigen::VectorXd size_;
  std::vector<std::optional<Strata>> strata_ = std::vector<std::optional<Strata>>(64);
};

template <class Scalar, class Value>
void fill(const DensityGrid& grid, std::span<const Value> values, std::uint64_t seed,
          DensitySampling sampling, std::span<Scalar> coordinates) {
  check_shape(grid, values.size());
  const double total = check_values(grid, values);
  const auto count = static_cast<Index>(coordinates.size() / grid.shape.size());
  const Random random(seed, streams::density_mass);
  const bool stratified = sampling == DensitySampling::stratified;
  CellFill<Scalar> cells(grid, seed, stratified, coordinates.data());
  const auto place = [&](std::int64_t cell, Index hits) { cells(cell, hits); };
  const auto value = [&](std::int64_t cell) {
    return static_cast<double>(values[static_cast<std::size_t>(cell)]);
  };
  if (stratified) {
    HilbertCurve curve(grid.shape);
    const auto along_curve = [&](const auto& f) {
      curve.visit([&](std::int64_t cell) { f(cell, value(cell)); });
    };
    deal(total, count, along_curve, StratifiedDraws(random, count), place);
  } else {
    const auto in_memory_order = [&](const auto& f) {
      for (std::int64_t cell = 0; cell < std::ssize(values); ++cell) f(cell, value(cell));
    };
    deal(total, count, in_memory_order, SortedDraws(random, count), place);
  }
}

template <class Scalar>
void fill(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
          std::span<Scalar> coordinates) {
  std::visit([&](const auto& values) { fill(grid, values, seed, sampling, coordinates); },
             grid.values);
}

}  // namespace

namespace detail {

void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                  std::span<float> coordinates) {
  fill(grid, seed, sampling, coordinates);
}

void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                  std::span<double> coordinates) {
  fill(grid, seed, sampling, coordinates);
}

}  // namespace detail
}  // namespace ccvt
