#include "scales.h"

#include <string>
#include <vector>

#include "format.h"

namespace ccvt {

template <class Scalar>
double require_moderate(const char* argument, const PointsView<Scalar>& points) {
  const double largest = largest_coordinate<Scalar>(points.dimension);
  const auto dimension = static_cast<std::size_t>(points.dimension);
  if (points.count == 0) return 0;
  std::vector<Scalar> lower(points[0], points[0] + dimension);
  std::vector<Scalar> upper = lower;
  for (Index p = 0; p < points.count; ++p) {
    const Scalar* x = points[p];
    for (std::size_t d = 0; d < dimension; ++d) {
      lower[d] = std::min(lower[d], x[d]);
      upper[d] = std::max(upper[d], x[d]);
      if (std::abs(static_cast<double>(x[d])) <= largest) continue;
      throw InvalidInput(
          std::string(argument) + ": coordinate " + std::to_string(d) + " of " + argument + "[" +
          std::to_string(p) + "] is " + text(static_cast<double>(x[d])) +
          ": coordinates must be finite and at most " + text(largest) + " in magnitude");
    }
  }
  double widest = 0;
  for (std::size_t d = 0; d < dimension; ++d) {
    widest = std::max(widest, static_cast<double>(upper[d]) - static_cast<double>(lower[d]));
  }
  return widest;
}

template <class Scalar>
void require_scale(const char* argument, const PointsView<Scalar>& points) {
  const double widest = require_moderate(argument, points);
  if (widest == 0 || widest >= kSmallestExtent<Scalar>) return;
  throw InvalidInput(std::string(argument) + ": their coordinates differ by at most " +
                     text(widest) + ": they must be all equal or differ by " +
                     text(kSmallestExtent<Scalar>) +
                     " or more somewhere; multiply them by a power of two");
}

template double require_moderate(const char*, const PointsView<float>&);
template double require_moderate(const char*, const PointsView<double>&);
template void require_scale(const char*, const PointsView<float>&);
template void require_scale(const char*, const PointsView<double>&);

}  // namespace ccvt
