#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>

#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/types.h"

namespace ccvt {

/// How uniform points are laid out in a box.
enum class Distribution {
  /// Independent uniform draws: what the paper recommends.
  white,
  /// One uniform draw in each cell of a grid with as many cells as points. The default: at the same
  /// cost, sites come out with far less low-frequency noise than from white points: with 1024 sites
  /// of 256 points on the torus, the mean power below a quarter of sqrt(#sites) falls from .0042
  /// to .0002, and no lattice shows.
  jittered,
  /// The centres of that grid. Leaves its structure in the sites.
  square,
  /// A hexagonal lattice in two dimensions: rows along the first, every other one shifted by half
  /// a spacing. A body-centred grid in three and more: two points on a diagonal of each cell of a
  /// grid (for an odd count, one in the centre of the last cell). In one dimension, as `square`.
  /// Leaves its structure in the sites.
  hexagonal,
};

namespace detail {
/// Throws InvalidInput unless `sample_uniform` can do as asked. `fixed_dimension`: -1 for Dynamic.
CCVT_EXPORT void check_sampling(const Box& box, std::int64_t count, int fixed_dimension,
                                std::size_t scalar_bytes);
/// Fills #dimensions * count coordinates. The arguments have passed check_sampling().
CCVT_EXPORT void fill_uniform(const Box& box, std::uint64_t seed, Distribution distribution,
                              int threads, std::span<float> coordinates);
CCVT_EXPORT void fill_uniform(const Box& box, std::uint64_t seed, Distribution distribution,
                              int threads, std::span<double> coordinates);
/// Of `count` points those from `first` on, as many as there is room for.
CCVT_EXPORT void fill_uniform_part(const Box& box, std::int64_t count, std::int64_t first,
                                   std::uint64_t seed, Distribution distribution, int threads,
                                   std::span<float> coordinates);
CCVT_EXPORT void fill_uniform_part(const Box& box, std::int64_t count, std::int64_t first,
                                   std::uint64_t seed, Distribution distribution, int threads,
                                   std::span<double> coordinates);
}  // namespace detail

/// Exactly `count` points, #dimensions by #points, that spread uniformly over `box`, in float or
/// double and in a fixed or dynamic number of dimensions:
///
///     Eigen::Matrix2Xf points = ccvt::sample_uniform<float, 2>(ccvt::Box::unit(2), 1 << 18, seed);
///
/// Every coordinate lies in [lower, upper), after rounding to Scalar too. The bits depend on the
/// arguments only, not on `threads` (0: one per processor), which draw many points at once.
/// Neighbours in memory are neighbours in space, except for white points.
///
/// The grid that jittered, square and body-centred points use has cells of exactly equal volume and
/// as cubic as possible for any count and any box: the box is cut into slabs, these into smaller
/// slabs along the next dimension, and so on, in numbers that divide the count where some do so
/// with nearly cubic cells, and otherwise into slabs as thick as their numbers of points, which
/// differ by at most one. Cells of a square are at most twice as long as wide from 8 points on (3
/// times below), and rows of hexagonal points follow the same rule. In higher dimensions, sides
/// that are cut differ by less than a factor of 3; those that are too short to be cut, or too many,
/// keep their full length.
///
/// O(#dimensions * count) time; no memory beyond the result. Throws InvalidInput when count < 1;
/// when the box has no dimension, a NaN or infinite corner or extent, or no number of type Scalar
/// between lower and upper in some dimension; when its dimension is not `Dimension`; and when the
/// points would exceed the address space.
template <class Scalar = double, int Dimension = Eigen::Dynamic>
Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> sample_uniform(
    const Box& box, Index count, std::uint64_t seed = 0,
    Distribution distribution = Distribution::jittered, int threads = 1) {
  detail::check_sampling(box, count, Dimension, sizeof(Scalar));
  Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> points(box.dimension(), count);
  detail::fill_uniform(box, seed, distribution, threads,
                       std::span<Scalar>(points.data(), static_cast<std::size_t>(points.size())));
  return points;
}

/// Of the points that sample_uniform() gives, those from `first` up to `end` - 1, perhaps none:
/// what one of several processes draws of them. Throws InvalidInput as sample_uniform() does, and
/// unless 0 <= first <= end <= count, which may be up to 2^40, and end - first up to 2^31 - 1.
/// O(#dimensions * (end - first) + rows) time, with about count^(1/2) rows where the box is not
/// much longer than wide.
template <class Scalar = double>
Points<Scalar> sample_uniform_part(const Box& box, std::int64_t count, std::int64_t first,
                                   std::int64_t end, std::uint64_t seed = 0,
                                   Distribution distribution = Distribution::jittered,
                                   int threads = 1) {
  detail::check_sampling(box, count, Eigen::Dynamic, sizeof(Scalar));
  if (first < 0 || first > end || end > count) {
    throw InvalidInput("first: the points " + std::to_string(first) + " to " + std::to_string(end) +
                       " are asked for, of " + std::to_string(count) +
                       ": it must hold that 0 <= first <= end <= count");
  }
  if (end - first > std::numeric_limits<Index>::max()) {
    throw InvalidInput("end: " + std::to_string(end - first) +
                       " points are asked for: at most 2147483647 are drawn at once");
  }
  Points<Scalar> points(box.dimension(), end - first);
  detail::fill_uniform_part(
      box, count, first, seed, distribution, threads,
      std::span<Scalar>(points.data(), static_cast<std::size_t>(points.size())));
  return points;
}

}  // namespace ccvt
