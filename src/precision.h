#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"
#include "median.h"
#include "number_text.h"

namespace ccvt {

/// How far apart neighbouring points are, from what their tessellation costs; infinite where that
/// says nothing, as when each point has a site of its own.
inline double spacing_in_cells(double energy, std::int64_t points, Index sites, int dimension) {
  if (!(energy > 0)) return std::numeric_limits<double>::infinity();
  // A cube of side a has a mean square of a^2 / 12 along each axis.
  const auto all = static_cast<double>(points);
  const double side = std::sqrt(12 * energy / all / dimension);
  return side / std::pow(all / sites, 1.0 / dimension);
}

/// The most that they can be apart when they fill a box.
inline double spacing_in_box(const Box& box, std::int64_t points) {
  return box.extent().maxCoeff() / std::pow(static_cast<double>(points), 1.0 / box.dimension());
}

/// The numbers of the points, of `count`, that coarse_coordinates() looks at: enough for a median.
inline std::vector<Index> looked_at(Index count) {
  constexpr Index kLooked = 1001;
  const Index looked = std::min(count, kLooked);
  std::vector<Index> numbers;
  for (Index k = 0; k < looked; ++k) {
    const double part = k;
    numbers.push_back(static_cast<Index>(part * count / looked));
  }
  return numbers;
}

/// What is wrong with points that are `spacing` apart when most are so far from the origin that
/// `Stored`, the type that they were given in, has steps of more than half of that; or nothing.
template <class Stored, class Scalar>
std::string coarse_coordinates(const char* what, PointsView<Scalar> points, double spacing) {
  const std::vector<Index> looked = looked_at(points.count);
  double worst = 0;
  double where = 0;
  int axis = 0;
  std::vector<double> sizes;
  for (int d = 0; d < points.dimension; ++d) {
    sizes.clear();
    for (const Index p : looked) {
      const double x = points[p][d];
      sizes.push_back(std::abs(x));
    }
    const double middle = median(sizes);
    const auto size = static_cast<Stored>(middle);
    const double step = std::nextafter(size, std::numeric_limits<Stored>::infinity()) - size;
    if (step <= worst) continue;
    worst = step;
    where = middle;
    axis = d;
  }
  if (points.count < 2 || !(2 * worst > spacing)) return {};
  const std::string type = sizeof(Stored) == sizeof(float) ? "float32" : "float64";
  if (spacing == 0) {
    return std::string(what) + ": all are in one place, as far as " + type + " can tell";
  }
  return std::string(what) + ": coordinate " + std::to_string(axis) + " is about " +
         text(where, 3) + ", where " + type + " has steps of " + text(worst, 2) +
         ", but they are about " + text(spacing, 2) + " apart: give them " +
         (type == "float32" ? "as float64, or " : "") + "relative to a place among them";
}

}  // namespace ccvt
