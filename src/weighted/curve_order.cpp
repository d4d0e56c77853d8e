#include "weighted/curve_order.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>

#include "sampling/hilbert.h"

namespace ccvt {
namespace {

/// So many points stay in the order they have.
constexpr std::size_t kFewPoints = 4;

/// A grid of about as many cells as there are points, in the box around them.
struct Grid {
  std::vector<double> lower;
  std::vector<double> cells_per_length;  ///< along each side; 0 where it has one cell
  std::vector<std::int64_t> shape;
  std::size_t cells = 1;
};

template <class Scalar>
Grid grid_of(PointsView<Scalar> points, std::span<const PointNumber> which) {
  const auto width = static_cast<std::size_t>(points.dimension);
  Grid grid;
  grid.shape.assign(width, 1);
  const Scalar* const first = points[which.front().index()];
  grid.lower.assign(first, first + width);
  std::vector<double> upper = grid.lower;
  for (const PointNumber p : which) {
    const Scalar* const x = points[p.index()];
    for (std::size_t d = 0; d < width; ++d) {
      const double at = x[d];
      grid.lower[d] = std::min(grid.lower[d], at);
      upper[d] = std::max(upper[d], at);
    }
  }
  std::vector<double> side(width);  // of a cell
  for (std::size_t d = 0; d < width; ++d) side[d] = upper[d] - grid.lower[d];
  for (; grid.cells < which.size(); grid.cells *= 2) {
    const auto widest = std::max_element(side.begin(), side.end());
    if (!(*widest > 0)) break;
    *widest /= 2;
    grid.shape[static_cast<std::size_t>(widest - side.begin())] *= 2;
  }
  grid.cells_per_length.assign(width, 0);
  for (std::size_t d = 0; d < width; ++d) {
    const double inverse = 1 / side[d];
    if (grid.shape[d] > 1 && std::isfinite(inverse)) grid.cells_per_length[d] = inverse;
  }
  return grid;
}

template <class Scalar>
std::size_t cell_of(const Grid& grid, const Scalar* x) {
  std::int64_t cell = 0;
  std::int64_t stride = 1;
  for (std::size_t d = 0; d < grid.shape.size(); ++d) {
    if (grid.shape[d] == 1) continue;
    const auto along = static_cast<std::int64_t>((x[d] - grid.lower[d]) * grid.cells_per_length[d]);
    cell += stride * std::min(along, grid.shape[d] - 1);
    stride *= grid.shape[d];
  }
  return static_cast<std::size_t>(cell);
}

template <class Scalar>
void put_in_order(PointsView<Scalar> points, std::span<PointNumber> which, const Arena& arena) {
  if (which.size() <= kFewPoints) return;
  arena.check();
  const Grid grid = grid_of(points, std::span<const PointNumber>(which));
  if (grid.cells == 1) return;
  std::vector<Index> held(grid.cells, 0);
  std::vector<std::size_t> cell(which.size());
  for (std::size_t k = 0; k < which.size(); ++k) {
    cell[k] = cell_of(grid, points[which[k].index()]);
    ++held[cell[k]];
  }
  std::vector<std::size_t> first(grid.cells);
  std::vector<std::size_t> crowded;
  std::size_t place = 0;
  HilbertCurve(grid.shape).visit([&](std::int64_t index) {
    const auto c = static_cast<std::size_t>(index);
    first[c] = place;
    place += static_cast<std::size_t>(held[c]);
    if (static_cast<std::size_t>(held[c]) > kFewPoints) crowded.push_back(c);
  });
  const std::vector<PointNumber> before(which.begin(), which.end());
  for (std::size_t k = 0; k < before.size(); ++k) which[first[cell[k]]++] = before[k];
  for (const std::size_t c : crowded) {
    const auto count = static_cast<std::size_t>(held[c]);
    if (count < which.size()) {
      put_in_order(points, which.subspan(first[c] - count, count), arena);
    }
  }
}

}  // namespace

template <class Scalar>
std::vector<PointNumber> curve_order(PointsView<Scalar> points, std::vector<PointNumber> which,
                                     const Arena& arena) {
  put_in_order(points, std::span(which), arena);
  return which;
}

template std::vector<PointNumber> curve_order(PointsView<float>, std::vector<PointNumber>,
                                              const Arena&);
template std::vector<PointNumber> curve_order(PointsView<double>, std::vector<PointNumber>,
                                              const Arena&);

}  // namespace ccvt
