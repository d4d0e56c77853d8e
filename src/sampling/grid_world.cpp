#include "sampling/grid_world.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace ccvt {

Box world_box(const DensityGrid& grid) {
  if (!grid.to_world) return grid.box;
  const Affine& map = *grid.to_world;
  const Eigen::VectorXd centre =
      map.matrix.eigen() * (0.5 * (grid.box.lower.eigen() + grid.box.upper.eigen())) +
      map.offset.eigen();
  const Eigen::VectorXd reach = map.matrix.eigen().cwiseAbs() * (0.5 * grid.box.extent());
  return {centre - reach, centre + reach};
}

CellLocator::CellLocator(const DensityGrid& grid)
    : shape_(grid.shape), last_(cells_along(grid).array() - 1) {
  const Eigen::MatrixXd cells = cells_along(grid).cwiseQuotient(grid.box.extent()).asDiagonal();
  corner_ = grid.box.lower.eigen();
  to_cells_ = cells;
  if (!grid.to_world) return;
  corner_ = grid.to_world->matrix.eigen() * grid.box.lower.eigen() + grid.to_world->offset.eigen();
  to_cells_ = cells * grid.to_world->matrix.eigen().inverse();
}

std::int64_t CellLocator::operator()(const double* place) const {
  const Eigen::Index dimension = last_.size();
  std::int64_t cell = 0;
  for (Eigen::Index d = dimension - 1; d >= 0; --d) {
    double x = 0;
    for (Eigen::Index e = 0; e < dimension; ++e) x += to_cells_(d, e) * (place[e] - corner_[e]);
    const double position = std::clamp(std::floor(x), 0.0, last_[d]);
    cell = cell * shape_.data()[d] + static_cast<std::int64_t>(position);
  }
  return cell;
}

LocalDensity around_middle(const DensityGrid& density) {
  LocalDensity local{density, {}};
  const Eigen::VectorXd middle = 0.5 * (density.box.lower.eigen() + density.box.upper.eigen());
  if (density.to_world) {
    const Eigen::VectorXd back = -(density.to_world->matrix.eigen() * middle);
    local.origin = density.to_world->offset.eigen() - back;
    local.grid.to_world->offset = back;
  } else {
    const Eigen::VectorXd half = 0.5 * density.box.extent();
    local.origin = middle;
    local.grid.box = {-half, half};
  }
  return local;
}

}  // namespace ccvt
