#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "ccvt/density.h"
#include "ccvt/ranks.h"

namespace ccvt {

/// What holds all points of a density: its box, or a box around what becomes of it.
Box world_box(const DensityGrid& grid);

/// The numbers of cells along each dimension.
inline Eigen::VectorXd cells_along(const DensityGrid& grid) {
  using Cells = Eigen::VectorX<std::int64_t>;
  return Eigen::Map<const Cells>(grid.shape.data(), std::ssize(grid.shape)).cast<double>();
}

/// Index of a cell along each dimension.
inline void cell_position(std::int64_t cell, std::span<const std::int64_t> shape,
                          std::span<std::int64_t> position) {
  for (std::size_t d = 0; d < shape.size(); ++d) {
    position[d] = cell % shape[d];
    cell /= shape[d];
  }
}

/// Finds the cells of a grid at places of the world. `grid` must be valid.
class CellLocator {
 public:
  explicit CellLocator(const DensityGrid& grid);

  /// The number of the cell that holds a place, or the nearest one along each axis.
  [[nodiscard]] std::int64_t operator()(const double* place) const;

  /// How far along each axis of the grid, in cells, an error of `errors` in each coordinate of the
  /// world may move a place.
  [[nodiscard]] Eigen::VectorXd reach(const Eigen::VectorXd& errors) const {
    return to_cells_.cwiseAbs() * errors;
  }

 private:
  std::vector<std::int64_t> shape_;
  Eigen::VectorXd last_;  // the last cell along each dimension
  Eigen::MatrixXd to_cells_;
  Eigen::VectorXd corner_;  // in the world: of the first cell
};

/// The same density in a world that has been moved: what is at `origin` there is at 0 here.
struct LocalDensity {
  DensityGrid grid;
  Eigen::VectorXd origin;
};

/// Moves the middle of a grid to 0. `grid` depends on shape, values and axes only: the same bits
/// wherever the density was.
LocalDensity around_middle(const DensityGrid& density);

/// As sample_density(), of local.grid: points that are in the cells they should be in even after
/// local.origin has been added to them, in double.
template <class Scalar>
Points<Scalar> sample_local_density(const LocalDensity& local, Index count, std::uint64_t seed,
                                    DensitySampling sampling, int threads,
                                    const std::function<bool()>& cancelled = {});

/// The same of the points of this rank: see sample_density(). `layers` are those of local.grid that
/// are here; the arguments have passed check_density().
template <class Scalar>
Points<Scalar> sample_local_density(Ranks& ranks, const LocalDensity& local,
                                    const LayerRange& layers, std::int64_t count,
                                    std::uint64_t seed, DensitySampling sampling, int threads);

}  // namespace ccvt
