#include "thin/lift.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/metric.h"
#include "median.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/loops.h"
#include "random.h"
#include "spatial/site_tree.h"
#include "streams.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = std::size_t{1} << 14;
constexpr std::size_t kQueries = 2048;
/// Of the packed spacing to the median distance of a random point to its nearest: 2.29 on surfaces,
/// 2.04 in space.
constexpr double kPacked = 2.2;

/// `count` of the points, each set of so many equally likely, one after the other.
template <class Scalar>
std::vector<double> draw(PointsView<Scalar> points, Index count, std::uint64_t seed) {
  std::vector<double> drawn;
  drawn.reserve(static_cast<std::size_t>(count) * static_cast<std::size_t>(points.dimension));
  Random(seed, streams::thin_spacing).choose(count, points.count, [&](Index p) {
    drawn.insert(drawn.end(), points[p], points[p] + points.dimension);
  });
  return drawn;
}

/// Throws for the first that is not.
template <class Scalar>
void require_finite(PointsView<Scalar> normals, const Arena& arena) {
  const auto all = static_cast<std::size_t>(normals.count);
  const auto is_bad = [&](std::size_t k) {
    const Scalar* const normal = normals[PointNumber(k).index()];
    return std::any_of(normal, normal + normals.dimension,
                       [](Scalar x) { return !std::isfinite(x); });
  };
  const std::size_t first = reduce(
      arena, all, kPointsPerGrain, all,
      [&](std::size_t begin, std::size_t end) {
        while (begin < end && !is_bad(begin)) ++begin;
        return begin < end ? begin : all;
      },
      [](std::size_t a, std::size_t b) { return std::min(a, b); });
  if (first == all) return;
  const Index p = PointNumber(first).index();
  int d = 0;
  while (std::isfinite(normals[p][d])) ++d;
  throw InvalidInput(concat("normals: normal ", p, " has the coordinate ", normals[p][d],
                            " in dimension ", d, "; coordinates must be finite"));
}

}  // namespace

template <class Scalar>
double typical_spacing(PointsView<Scalar> points, Index sites, std::uint64_t seed,
                       const Arena& arena) {
  if (sites < 2) return 0;
  const Metric metric(points.dimension, Domain());
  const std::vector<double> drawn = draw(points, sites, seed);
  const SiteTree tree(metric, drawn);
  const auto width = static_cast<std::size_t>(points.dimension);
  const auto count = static_cast<std::size_t>(sites);
  const std::size_t step = (count + kQueries - 1) / kQueries;
  const std::size_t queries = (count + step - 1) / step;
  std::vector<double> distances(queries);
  arena.for_each(queries, 64, [&](std::size_t k) {
    const double* const at = &drawn[k * step * width];
    std::vector<Index> two;
    tree.nearest(at, 2, two);
    double squared = 0;
    for (const Index other : two) {
      squared = std::max(squared, metric.squared_distance(at, &drawn[SiteNumber(other) * width]));
    }
    distances[k] = std::sqrt(squared);
  });
  std::erase(distances, 0.0);  // of points in one place, which are of no spacing
  return distances.empty() ? 0 : kPacked * median(distances);
}

template <class Scalar>
Points<Scalar> lift(PointsView<Scalar> points, PointsView<Scalar> normals, double length,
                    const Arena& arena) {
  require_finite(normals, arena);
  Points<Scalar> lifted(points.dimension + normals.dimension, points.count);
  arena.for_each(static_cast<std::size_t>(points.count), kPointsPerGrain, [&](std::size_t k) {
    const Index p = PointNumber(k).index();
    Scalar* const to = lifted.col(p).data();
    std::copy_n(points[p], points.dimension, to);
    const Scalar* const normal = normals[p];
    double largest = 0;
    for (int d = 0; d < normals.dimension; ++d) {
      largest = std::max(largest, std::abs(static_cast<double>(normal[d])));
    }
    double squared = 0;  // of the normal over its largest coordinate, whatever its size
    for (int d = 0; d < normals.dimension && largest > 0; ++d) {
      const double x = normal[d] / largest;
      squared += x * x;
    }
    for (int d = 0; d < normals.dimension; ++d) {
      const double x = largest > 0 ? normal[d] / largest / std::sqrt(squared) : 0.0;
      to[points.dimension + d] = static_cast<Scalar>(length * x);
    }
  });
  return lifted;
}

template double typical_spacing(PointsView<float>, Index, std::uint64_t, const Arena&);
template double typical_spacing(PointsView<double>, Index, std::uint64_t, const Arena&);
template Points<float> lift(PointsView<float>, PointsView<float>, double, const Arena&);
template Points<double> lift(PointsView<double>, PointsView<double>, double, const Arena&);

}  // namespace ccvt
