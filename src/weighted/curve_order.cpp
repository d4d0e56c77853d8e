#include "weighted/curve_order.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "sampling/curve_grid.h"

namespace ccvt {
namespace {

/// So many points stay in the order they have.
constexpr std::size_t kFewPoints = 4;

/// Of about as many cells as there are points, in the box around them.
template <class Scalar>
CurveGrid grid_of(PointsView<Scalar> points, std::span<const PointNumber> which) {
  const Scalar* const first = points[which.front().index()];
  std::vector<double> lower(first, first + points.dimension);
  std::vector<double> upper = lower;
  for (const PointNumber p : which) {
    const Scalar* const x = points[p.index()];
    for (std::size_t d = 0; d < lower.size(); ++d) {
      const double at = x[d];
      lower[d] = std::min(lower[d], at);
      upper[d] = std::max(upper[d], at);
    }
  }
  return {std::move(lower), upper, which.size()};
}

template <class Scalar>
void put_in_order(PointsView<Scalar> points, std::span<PointNumber> which, const Arena& arena) {
  if (which.size() <= kFewPoints) return;
  arena.check();
  const CurveGrid grid = grid_of(points, std::span<const PointNumber>(which));
  if (grid.count() == 1) return;
  std::vector<Index> held(grid.count(), 0);
  std::vector<std::size_t> cell(which.size());
  for (std::size_t k = 0; k < which.size(); ++k) {
    cell[k] = grid.cell_of(points[which[k].index()]);
    ++held[cell[k]];
  }
  std::vector<std::size_t> first(grid.count());
  std::vector<std::size_t> crowded;
  std::size_t place = 0;
  grid.visit_along_curve([&](std::size_t c) {
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
