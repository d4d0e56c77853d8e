#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "kernels/nearest.h"
#include "numbers.h"

namespace ccvt {

/// By what share of them sums of squares, and differences of such sums, may be off, and by how much
/// beside that.
inline double rounding_share(int dimension) { return 1e-14 * (1 + dimension / 64.0); }
inline double underflow_of(int dimension) { return dimension * std::numeric_limits<double>::min(); }

/// |x - position|^2 of what is at at(k), for each of `which`; without a torus.
template <class Number, class At>
void squared_distances(std::span<const Number> which, const At& at, int dimension,
                       const double* position, std::vector<double>& out) {
  constexpr std::size_t kRows = 64;
  std::array<decltype(at(which.front())), kRows> row{};
  out.resize(which.size());
  for (std::size_t begin = 0; begin < which.size(); begin += kRows) {
    const auto some = which.subspan(begin, std::min(kRows, which.size() - begin));
    std::transform(some.begin(), some.end(), row.begin(), at);
    kernels::squared_distances_of(row.data(), static_cast<Index>(some.size()), dimension, position,
                                  out.data() + begin);
  }
}

/// |p - position|^2 of some points, without a torus.
template <class Scalar>
void squared_distances(PointsView<Scalar> points, std::span<const PointNumber> which,
                       const double* position, std::vector<double>& out) {
  squared_distances(
      which, [&](PointNumber p) { return points[p.index()]; }, points.dimension, position, out);
}

/// The same, on a torus if the metric is of one.
template <class Scalar>
void squared_distances(const Metric& metric, PointsView<Scalar> points,
                       std::span<const PointNumber> which, const double* position,
                       std::vector<double>& out) {
  if (!metric.periodic()) return squared_distances(points, which, position, out);
  out.resize(which.size());
  std::transform(which.begin(), which.end(), out.begin(), [&](PointNumber p) {
    return metric.squared_distance(points[p.index()], position);
  });
}

}  // namespace ccvt
