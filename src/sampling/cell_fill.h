#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "ccvt/density.h"
#include "random.h"
#include "sampling/cell_densities.h"
#include "sampling/grid_world.h"
#include "sampling/scalar_box.h"
#include "sampling/strata.h"

namespace ccvt {

/// Puts points of the density of single cells into the world, `origin` of which will be added to
/// them in double. One per thread.
template <class Scalar>
class CellFill {
 public:
  CellFill(const DensityGrid& grid, const CellDensities& densities, const Eigen::VectorXd& origin,
           bool jittered)
      : grid_(grid),
        densities_(densities),
        bounds_(world_box(grid)),
        jittered_(jittered),
        cell_(grid.box.extent().cwiseQuotient(cells_along(grid))),
        edges_(cell_),
        margin_(margin(grid, origin)),
        position_(grid.shape.size()),
        inside_(grid.shape.size()),
        side_(grid.shape.size()),
        place_(grid.box.lower.eigen()) {
    if (!grid.to_world) return;
    for (Eigen::Index d = 0; d < cell_.size(); ++d) {
      edges_[d] *= grid.to_world->matrix.col(d).norm();
    }
  }

  /// Points of the density of one cell, one behind the other in memory; returns where they end.
  Scalar* operator()(std::int64_t cell, std::int64_t hits, Random& random, Scalar* out) {
    cell_position(cell, grid_.shape, position_);
    const std::size_t dimension = position_.size();
    if (hits == 1 || !jittered_) {
      for (std::int64_t k = 0; k < hits; ++k) {
        for (std::size_t d = 0; d < dimension; ++d) put(d, random.uniform());
        out = store(cell, out);
      }
      return out;
    }
    const double* const edges = edges_.data();
    strata(hits).visit(
        Eigen::VectorXd::Zero(cell_.size()), 0, hits,
        [&](std::int64_t, std::span<const double> corner, std::span<const double> size) {
          for (std::size_t d = 0; d < dimension; ++d) {
            put(d, std::min((corner[d] + random.uniform() * size[d]) / edges[d], below_one));
          }
          out = store(cell, out);
        });
    return out;
  }

 private:
  static constexpr double below_one = 1 - 0x1p-53;
  static constexpr double most_margin = 0.25;
  static constexpr int kept_strata = 64;

  // How far, in cells, points must keep off the borders of their cells so that rounding does not
  // take them over: to Scalar, and in double wherever the world and its cells are computed.
  static Eigen::VectorXd margin(const DensityGrid& grid, const Eigen::VectorXd& origin) {
    const Box world = world_box(grid);
    const Eigen::VectorXd local =
        world.lower.eigen().cwiseAbs().cwiseMax(world.upper.eigen().cwiseAbs());
    const double wide = std::numeric_limits<double>::epsilon() * (3 + grid.box.dimension());
    constexpr double narrow = std::numeric_limits<Scalar>::epsilon();
    const CellLocator locator(grid);
    // The greater one, doubled, is as much as their sum, and the same wherever the origin is, as
    // long as Scalar is the coarser of the two.
    return (2 * locator.reach(narrow * local)
                    .cwiseMax(locator.reach(wide * (local + origin.cwiseAbs()))))
        .cwiseMin(most_margin);
  }

  // The coordinate that has a share u of the density of the cell below it, from 0 to 1 in the cell.
  void put(std::size_t d, double u) {
    if (grid_.interpolation == Interpolation::constant) {
      inside_[d] = u;
      return;
    }
    // Under a tent from -1 to 1 around the centre, mirrored at the faces of the box.
    double x = 0.5 + (u < 0.5 ? std::sqrt(2 * u) - 1 : 1 - std::sqrt(2 * (1 - u)));
    if (x < 0 && position_[d] == 0) x = -x;
    if (x >= 1 && position_[d] + 1 == grid_.shape[d]) x = std::min(2 - x, below_one);
    inside_[d] = x;
  }

  // Mirrors a place in a neighbour without density at the faces of the cell, towards its inside;
  // keeps it off the borders, and finishes place_.
  void settle(std::int64_t cell) {
    std::int64_t stride = 1;
    std::int64_t landed = cell;
    for (std::size_t d = 0; d < inside_.size(); ++d) {
      side_[d] = inside_[d] < 0 ? -1 : inside_[d] >= 1 ? 1 : 0;
      landed += side_[d] * stride;
      stride *= grid_.shape[d];
    }
    const bool mirrored = landed != cell && !(densities_(landed) > 0);
    const double* const margins = margin_.data();
    const double* const lower = grid_.box.lower.data();
    for (std::size_t d = 0; d < inside_.size(); ++d) {
      double x = inside_[d] - side_[d];  // in the cell that it is in
      if (mirrored && side_[d] != 0) {
        x = 1 - x;
        side_[d] = 0;
      }
      x = margins[d] + (1 - 2 * margins[d]) * x;
      const auto position = static_cast<double>(position_[d]);
      place_.data()[d] = lower[d] + (position + side_[d] + x) * cell_.data()[d];
    }
  }

  Scalar* store(std::int64_t cell, Scalar* out) {
    settle(cell);
    const std::size_t dimension = inside_.size();
    const double* const place = place_.data();
    for (std::size_t d = 0; d < dimension; ++d) {
      double x = place[d];
      if (grid_.to_world) {
        const double* const matrix = grid_.to_world->matrix.data();
        x = grid_.to_world->offset.data()[d];
        for (std::size_t e = 0; e < dimension; ++e) x += matrix[d + e * dimension] * place[e];
      }
      *out++ = bounds_.round(d, x);
    }
    return out;
  }

  // All cells have the same shape, and adjacent ones similar numbers of points.
  const Strata& strata(std::int64_t hits) {
    auto& strata = strata_.data()[hits % kept_strata];
    if (!strata || strata->count() != hits) strata.emplace(edges_, hits);
    return *strata;
  }

  const DensityGrid& grid_;
  const CellDensities& densities_;
  ScalarBox<Scalar> bounds_;
  bool jittered_;
  Eigen::VectorXd cell_;                // sides in the box
  Eigen::VectorXd edges_;               // and in the world
  Eigen::VectorXd margin_;              // in cells
  std::vector<std::int64_t> position_;  // of the cell
  std::vector<double> inside_;          // of the point, from 0 to 1 in the cell
  std::vector<int> side_;               // which neighbour it is in: -1, 0 or 1
  Eigen::VectorXd place_;
  std::vector<std::optional<Strata>> strata_ = std::vector<std::optional<Strata>>(kept_strata);
};

}  // namespace ccvt
