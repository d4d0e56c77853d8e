#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/loops.h"

namespace ccvt {

/// Over which coordinates points extend, in each dimension.
template <class Scalar>
struct CoordinateRange {
  std::vector<Scalar> lower;
  std::vector<Scalar> upper;
  bool ordered = true;  ///< none of them is not a number
};

template <class Scalar>
CoordinateRange<Scalar> coordinate_range(const PointsView<Scalar>& points, const Arena& arena) {
  using Range = CoordinateRange<Scalar>;
  constexpr std::size_t kBytesPerGrain = std::size_t{1} << 16;  // stay in the cache
  const std::size_t stride = sizeof(Scalar) * static_cast<std::size_t>(points.dimension);
  return reduce(
      arena, static_cast<std::size_t>(points.count), 64 + kBytesPerGrain / stride, Range{},
      [&](std::size_t begin, std::size_t end) {
        const Scalar* const first = points[PointNumber(begin).index()];
        Range range;
        range.lower.assign(first, first + points.dimension);
        range.upper = range.lower;
        bool ordered = true;
        for (std::size_t d = 0; d < range.lower.size(); ++d) {
          Scalar lower = first[d];
          Scalar upper = first[d];
          for (const PointNumber p : NumberRange(PointNumber(begin), PointNumber(end))) {
            const Scalar x = points[p.index()][d];
            lower = x < lower ? x : lower;
            upper = x > upper ? x : upper;
            ordered = ordered & !std::isnan(x);
          }
          range.lower[d] = lower;
          range.upper[d] = upper;
        }
        range.ordered = ordered;
        return range;
      },
      [](Range a, const Range& b) {
        for (std::size_t d = 0; d < a.lower.size(); ++d) {
          a.lower[d] = std::min(a.lower[d], b.lower[d]);
          a.upper[d] = std::max(a.upper[d], b.upper[d]);
        }
        a.ordered = a.ordered && b.ordered;
        return a;
      });
}

/// The smallest around points, of which there are some.
template <class Scalar>
Box box_around(const PointsView<Scalar>& points, const Arena& arena) {
  const CoordinateRange<Scalar> range = coordinate_range(points, arena);
  Box box = Box::unit(points.dimension);
  std::copy(range.lower.begin(), range.lower.end(), box.lower.data());
  std::copy(range.upper.begin(), range.upper.end(), box.upper.data());
  return box;
}

}  // namespace ccvt
