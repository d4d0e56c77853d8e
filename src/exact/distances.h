#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "geometry/squares.h"
#include "kernels/nearest.h"
#include "kernels/rows.h"
#include "numbers.h"

namespace ccvt {

/// By what share of them sums of squares, and differences of such sums, may be off, and by how much
/// beside that.
inline double rounding_share(int dimension) { return 1e-14 * (1 + dimension / 64.0); }
inline double underflow_of(int dimension) { return dimension * std::numeric_limits<double>::min(); }

/// A power of two that brings values up to `largest` to about 1 at most; no more than what still
/// has a square, and an inverse that has one.
inline double scale_for(double largest) {
  constexpr double kMostScale = 500;  // about half of double's exponent
  if (!(largest > 0)) return 1;
  return std::exp2(std::clamp(-std::ceil(std::log2(largest)), -kMostScale, kMostScale));
}

/// Rows that for_rows() passes on together.
inline constexpr std::size_t kRowsAtOnce = 64;

/// Calls visit(rows, count, begin) with where some of `which` are, by at(k), from which[begin] on.
template <class Number, class At, class Visit>
void for_rows(std::span<const Number> which, const At& at, const Visit& visit) {
  std::array<decltype(at(which.front())), kRowsAtOnce> row{};
  for (std::size_t begin = 0; begin < which.size(); begin += kRowsAtOnce) {
    const auto some = which.subspan(begin, std::min(kRowsAtOnce, which.size() - begin));
    std::transform(some.begin(), some.end(), row.begin(), at);
    visit(row.data(), static_cast<Index>(some.size()), begin);
  }
}

/// |x - position|^2 of what is at at(k), for each of `which`; without a torus.
template <class Number, class At>
void squared_distances(std::span<const Number> which, const At& at, int dimension,
                       const double* position, std::vector<double>& out) {
  out.resize(which.size());
  for_rows(which, at, [&](const auto* rows, Index count, std::size_t begin) {
    kernels::squared_distances_of(rows, count, dimension, position, out.data() + begin);
  });
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

/// |x - position|^2, without a torus: squared_difference() by kernels where that takes less time.
template <class Scalar>
double squared_distance(const Scalar* x, const double* position, int dimension) {
  constexpr int kManyDimensions = 96;
  if (dimension < kManyDimensions) return squared_difference(x, position, dimension);
  double squared = 0;
  kernels::squared_distances_of(&x, 1, dimension, position, &squared);
  return squared;
}

/// Adds what some points are relative to a position, in their order, to `sum`.
template <class Scalar>
void add_points(PointsView<Scalar> points, std::span<const PointNumber> which,
                const double* position, double* sum) {
  const auto at = [&](PointNumber p) { return points[p.index()]; };
  for_rows(which, at, [&](const Scalar* const* rows, Index count, std::size_t) {
    kernels::add_rows(rows, count, points.dimension, position, sum);
  });
}

}  // namespace ccvt
