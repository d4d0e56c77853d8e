#pragma once

#include <algorithm>
#include <limits>
#include <vector>

#include "ccvt/problem.h"
#include "numbers.h"
#include "parallel/loops.h"

namespace ccvt {

/// The problem's box, or the smallest around its points.
template <class Scalar>
Box bounding_box(const Problem<Scalar>& problem, const Arena& arena) {
  if (problem.domain().has_box()) return problem.domain().box();
  constexpr std::size_t kPointsPerGrain = std::size_t{1} << 13;  // stays in the cache
  const auto& points = problem.points();
  struct Range {
    std::vector<Scalar> lower;
    std::vector<Scalar> upper;
  };
  const Range all = reduce(
      arena, static_cast<std::size_t>(points.count), kPointsPerGrain, Range{},
      [&](std::size_t begin, std::size_t end) {
        const Scalar* const first = points[PointNumber(begin).index()];
        Range range;
        range.lower.assign(first, first + points.dimension);
        range.upper = range.lower;
        for (std::size_t d = 0; d < range.lower.size(); ++d) {
          Scalar lower = first[d];
          Scalar upper = first[d];
          for (const PointNumber p : NumberRange(PointNumber(begin), PointNumber(end))) {
            const Scalar x = points[p.index()][d];
            lower = x < lower ? x : lower;
            upper = x > upper ? x : upper;
          }
          range.lower[d] = lower;
          range.upper[d] = upper;
        }
        return range;
      },
      [](Range a, const Range& b) {
        for (std::size_t d = 0; d < a.lower.size(); ++d) {
          a.lower[d] = std::min(a.lower[d], b.lower[d]);
          a.upper[d] = std::max(a.upper[d], b.upper[d]);
        }
        return a;
      });
  Box box = Box::unit(problem.dimension());
  std::copy(all.lower.begin(), all.lower.end(), box.lower.data());
  std::copy(all.upper.begin(), all.upper.end(), box.upper.data());
  return box;
}

/// On the absolute values of all coordinates in it.
inline double largest_coordinate(const Box& box) {
  return std::max(box.lower.eigen().cwiseAbs().maxCoeff(), box.upper.eigen().cwiseAbs().maxCoeff());
}

}  // namespace ccvt
