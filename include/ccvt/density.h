#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <span>
#include <variant>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/sampling.h"
#include "ccvt/types.h"

namespace ccvt {

/// A piecewise constant density: a box cut into equal cells, with one value each. A view: the
/// values belong to somebody else. `values` takes any contiguous range of float or double:
///
///     ccvt::DensityGrid grid{pixels, {width, height}, box};
struct DensityGrid {
  /// One value per cell, not negative; the first dimension varies fastest.
  std::variant<std::span<const float>, std::span<const double>> values;
  /// Cells along each dimension of the box.
  std::vector<std::int64_t> shape;
  Box box;
};

/// A density at a point of a box: finite and not negative.
using DensityFunction = std::function<double(std::span<const double>)>;

/// How points are drawn from a density.
enum class DensitySampling {
  /// Independent draws.
  white,
  /// Stratified draws: every region gets its share of the points to within a few along its border.
  /// The default, for the reason given at Distribution::jittered.
  stratified,
};

namespace detail {
CCVT_EXPORT void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                              std::span<float> coordinates);
CCVT_EXPORT void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                              std::span<double> coordinates);
CCVT_EXPORT void fill_function(const DensityFunction& density, double maximum, const Box& box,
                               std::uint64_t seed, DensitySampling sampling,
                               std::span<float> coordinates);
CCVT_EXPORT void fill_function(const DensityFunction& density, double maximum, const Box& box,
                               std::uint64_t seed, DensitySampling sampling,
                               std::span<double> coordinates);
}  // namespace detail

/// Exactly `count` points, #dimensions by #points, distributed as the grid says. Points fill each
/// cell uniformly, and a cell of value 0 gets none.
///
/// white: independent draws, exact. stratified: the cells are lined up along a Hilbert curve, and
/// the k-th point is drawn from the k-th of `count` equal parts of the mass along that line; points
/// that fall into one cell are jittered in it. The expected number of points in any region is
/// exact, its variance far below that of white points. Points come in the order of the cells, which
/// for stratified points follows the curve.
///
/// O(#cells + #dimensions * count) time, about 10 to 30 ns a cell along the curve; no copy of the
/// grid and next to no memory beyond the result. Rounding to Scalar may move a point across the
/// border of its cell, but not out of the box. Throws InvalidInput as sample_uniform() does, and
/// when the shape does not match the box or the values, or a value (named by its index) is
/// negative, NaN or infinite, or all are zero, or their sum overflows.
template <class Scalar = double, int Dimension = Eigen::Dynamic>
Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> sample_density(
    const DensityGrid& grid, Index count, std::uint64_t seed = 0,
    DensitySampling sampling = DensitySampling::stratified) {
  detail::check_sampling(grid.box, count, Dimension, sizeof(Scalar));
  Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> points(grid.box.dimension(), count);
  detail::fill_density(grid, seed, sampling,
                       std::span<Scalar>(points.data(), static_cast<std::size_t>(points.size())));
  return points;
}

/// Exactly `count` points, #dimensions by #points, distributed in `box` in proportion to `density`,
/// any callable that gives a double for a std::span<const double> of coordinates, and that is
/// nowhere above `maximum`.
///
/// white: rejection: independent and exact.
///
/// stratified: the box is cut into nearly cubic cells, whose masses are estimated by the density at
/// one uniform draw each; points are dealt to cells along a Hilbert curve as in sample_density(),
/// and drawn inside a cell by rejection. There are 4 cells a point, or 16 where the density is
/// concentrated, and no fewer than 65536. Not quite unbiased: the expected density in a region is
/// off by a share of at most about v, the variance of the estimated total mass over its square;
/// v < maximum / (mean density * #cells), and far below it for smooth densities. The memory beyond
/// the result is 8 bytes a cell.
///
/// Both call the density about maximum / (mean density) times a point, stratified once more a cell.
/// It is called at points of type Scalar, so none is returned where it is 0.
///
/// Throws InvalidInput as sample_uniform() does; when `maximum` is not positive and finite; when
/// the density is negative, NaN or above `maximum` at some point (named); and when it is zero, or
/// so small against `maximum` that 10 million candidates for a point are refused.
template <class Scalar = double, int Dimension = Eigen::Dynamic>
Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> sample_function(
    const DensityFunction& density, double maximum, const Box& box, Index count,
    std::uint64_t seed = 0, DensitySampling sampling = DensitySampling::stratified) {
  detail::check_sampling(box, count, Dimension, sizeof(Scalar));
  Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> points(box.dimension(), count);
  detail::fill_function(density, maximum, box, seed, sampling,
                        std::span<Scalar>(points.data(), static_cast<std::size_t>(points.size())));
  return points;
}

}  // namespace ccvt
