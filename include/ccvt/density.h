#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/grid_values.h"
#include "ccvt/ranks.h"
#include "ccvt/sampling.h"
#include "ccvt/types.h"

namespace ccvt {

/// What the density is between the centres of the cells.
enum class Interpolation {
  /// Every cell has the density of its value throughout.
  constant,
  /// Multilinear between the 2^D nearest centres: linear along each axis. Beyond the outermost
  /// centres, and next to a cell of density 0, which stays empty, the density goes on as it is at
  /// the centre. The mass of the grid is the same as with `constant`.
  linear,
};

/// x -> matrix * x + offset.
struct Affine {
  Columns<double> matrix;  ///< #dimensions by #dimensions, not singular
  Coordinates offset;
};

/// A density on a box that is cut into equal cells, with one value each. A view: values and mask
/// belong to somebody else, and are used in place.
///
///     ccvt::DensityGrid grid{pixels, {width, height}, box};
struct DensityGrid {
  /// One value per cell; the first dimension varies fastest.
  GridValues values;
  /// Cells along each dimension of the box.
  std::vector<std::int64_t> shape;
  Box box;

  Interpolation interpolation = Interpolation::constant;
  /// Makes a density of a value; must be finite and not negative. Empty: the value itself. Called
  /// from several threads, twice a cell; for values of 8 or 16 bits a table takes its place.
  std::function<double(double)> map = {};
  /// Cells whose entry is 0 have the density 0. Empty, or one entry per cell.
  MaskView mask = {};
  /// Takes points drawn in the box to where they are wanted, such as from cells to millimetres.
  std::optional<Affine> to_world = {};
};

/// Layers of a grid, from `begin` to `end` - 1, perhaps none. A layer is what has the same index
/// along the last dimension that has more than one cell: values that follow each other in memory.
struct LayerRange {
  std::int64_t begin = 0;
  std::int64_t end = 0;
};

/// What one of several ranks has of a density.
struct DensityLayers {
  /// All of it, but that values, and mask, are those of these layers only.
  DensityGrid grid;
  /// As layers_of_rank() says.
  LayerRange layers;
};

/// The layers that a rank must have of a grid so that all can draw points from it: as many as the
/// others, to within 16 in three dimensions, and one to either side. `shape` as of a DensityGrid.
CCVT_EXPORT LayerRange layers_of_rank(std::span<const std::int64_t> shape, int rank, int ranks);

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
/// Throws InvalidInput unless the grid is one that points of `fixed_dimension` dimensions (-1 for
/// Dynamic) can be drawn from. Looks at no value.
CCVT_EXPORT void check_density(const DensityGrid& grid, Index count, int fixed_dimension,
                               std::size_t scalar_bytes);
CCVT_EXPORT void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                              int threads, std::span<float> coordinates,
                              const std::function<bool()>& cancelled);
CCVT_EXPORT void fill_density(const DensityGrid& grid, std::uint64_t seed, DensitySampling sampling,
                              int threads, std::span<double> coordinates,
                              const std::function<bool()>& cancelled);
/// The same for a rank's points, by all ranks together.
CCVT_EXPORT void check_density(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                               std::size_t scalar_bytes);
CCVT_EXPORT void fill_density(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                              std::uint64_t seed, DensitySampling sampling, int threads,
                              std::span<float> coordinates);
CCVT_EXPORT void fill_density(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                              std::uint64_t seed, DensitySampling sampling, int threads,
                              std::span<double> coordinates);
/// Of so many points, the first one of a rank.
inline std::int64_t first_of_rank(std::int64_t count, int rank, int ranks) {
  return count * rank / ranks;
}
CCVT_EXPORT void fill_function(const DensityFunction& density, double maximum, const Box& box,
                               std::uint64_t seed, DensitySampling sampling, int threads,
                               std::span<float> coordinates,
                               const std::function<bool()>& cancelled);
CCVT_EXPORT void fill_function(const DensityFunction& density, double maximum, const Box& box,
                               std::uint64_t seed, DensitySampling sampling, int threads,
                               std::span<double> coordinates,
                               const std::function<bool()>& cancelled);
}  // namespace detail

/// Exactly `count` points, #dimensions by #points, distributed as the grid says.
///
/// white: independent draws, exact. stratified: the cells are lined up along a Hilbert curve, and
/// the k-th point is drawn from the k-th of `count` equal parts of the mass along that line; points
/// that fall to one cell are jittered in it. The expected number of points in any region is
/// exact, its variance far below that of white points. Either way points come in the order of the
/// curve.
///
/// A multilinear density is a sum of tents: the value of a cell times a product of triangles, two
/// cells wide, around its centre. So a point is dealt to a cell as in a piecewise constant density,
/// and placed under its tent; what falls out of the box is mirrored at its faces, and what falls
/// into a cell of density 0 at the faces of its own cell. That is exact, in any number of
/// dimensions, and looks at no more than one neighbour.
///
/// No point lies in a cell of density 0, such as one outside the mask, unless Scalar is so coarse
/// there that it cannot tell the cells apart.
///
/// `cancelled`, when given, is asked a few times a second, from the thread that called; true makes
/// this throw Cancelled (types.h). So does sample_function().
///
/// `threads` 0: one per processor; any number gives identical bits. O(#cells + #dimensions *
/// count) time: about 1 ns a cell to add up the values, and 10 to 30 ns a cell along the curve;
/// no copy of the grid, and less than 1 byte for a hundred cells, and 4 for 16 white points, beyond
/// the result. Points keep off the borders of the cells by as much as rounding to Scalar may move
/// them. Throws InvalidInput as sample_uniform() does, and when the shape does not match the
/// box, the values or the mask, or a density (named by its index) is negative, NaN or infinite, or
/// all are zero, or their sum overflows, or to_world is singular or of another size.
template <class Scalar = double, int Dimension = Eigen::Dynamic>
Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> sample_density(
    const DensityGrid& grid, Index count, std::uint64_t seed = 0,
    DensitySampling sampling = DensitySampling::stratified, int threads = 0,
    const std::function<bool()>& cancelled = {}) {
  detail::check_density(grid, count, Dimension, sizeof(Scalar));
  Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> points(grid.box.dimension(), count);
  detail::fill_density(grid, seed, sampling, threads,
                       std::span<Scalar>(points.data(), static_cast<std::size_t>(points.size())),
                       cancelled);
  return points;
}

/// Of the points that sample_density() gives, to the bit, those of a rank: of rank r of R the ones
/// from count * r / R, rounded down, up to those of the next. All ranks call this together, each
/// with its layers of the same density. A rank draws the points in its layers, about a million at a
/// time, and sends each to the rank that it is of; it holds no other layers and no other points.
/// For white points each rank counts all draws, with 4 bytes for 16 of them. There may be 2^40
/// points in all, and 2^31 - 1 for each rank. Throws InvalidInput, on all ranks, when there are
/// more, as sample_density() does, and when the layers are not those of layers_of_rank().
template <class Scalar = double>
Points<Scalar> sample_density(Ranks& ranks, const DensityLayers& density, std::int64_t count,
                              std::uint64_t seed = 0,
                              DensitySampling sampling = DensitySampling::stratified,
                              int threads = 0) {
  detail::check_density(ranks, density, count, sizeof(Scalar));
  const std::int64_t first = detail::first_of_rank(count, ranks.rank(), ranks.count());
  const std::int64_t end = detail::first_of_rank(count, ranks.rank() + 1, ranks.count());
  Points<Scalar> points(density.grid.box.dimension(), end - first);
  detail::fill_density(ranks, density, count, seed, sampling, threads,
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
/// the result is 16 bytes a cell.
///
/// Both call the density about maximum / (mean density) times a point, stratified once more a cell.
/// It is called at points of type Scalar, so none is returned where it is 0. With `threads` other
/// than 1 (0: one per processor) it is called from several threads at once; any number gives
/// identical bits.
///
/// Throws InvalidInput as sample_uniform() does; when `maximum` is not positive and finite; when
/// the density is negative, NaN or above `maximum` at some point (named); and when it is zero, or
/// so small against `maximum` that 10 million candidates for a point are refused.
template <class Scalar = double, int Dimension = Eigen::Dynamic>
Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> sample_function(
    const DensityFunction& density, double maximum, const Box& box, Index count,
    std::uint64_t seed = 0, DensitySampling sampling = DensitySampling::stratified, int threads = 1,
    const std::function<bool()>& cancelled = {}) {
  detail::check_sampling(box, count, Dimension, sizeof(Scalar));
  Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> points(box.dimension(), count);
  detail::fill_function(density, maximum, box, seed, sampling, threads,
                        std::span<Scalar>(points.data(), static_cast<std::size_t>(points.size())),
                        cancelled);
  return points;
}

}  // namespace ccvt
