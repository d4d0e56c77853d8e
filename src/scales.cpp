#include "scales.h"

#include <string>
#include <vector>

#include "format.h"

namespace ccvt {

template <class Scalar>
double require_moderate(const char* argument, const PointsView<Scalar>& points) {
  const double largest = largest_coordinate<Scalar>(points.dimension);
  if (points.count == 0) return 0;
  std::vector<Scalar> lower(points[0], points[0] + points.dimension);
  std::vector<Scalar> upper = lower;
  for (Index p = 0; p < points.count; ++p) {
    const Scalar* x = points[p];
    for (std::size_t d = 0; d < lower.size(); ++d) {
      lower[d] = std::min(lower[d], x[d]);
      upper[d] = std::max(upper[d], x[d]);
      const double value = x[d];
      if (std::abs(value) <= largest) continue;
      throw InvalidInput(std::string(argument) + ": coordinate " + std::to_string(d) + " of " +
                         argument + "[" + std::to_string(p) + "] is " + text(value) +
                         ": coordinates must be finite and at most " + text(largest) +
                         " in magnitude");
    }
  }
  double widest = 0;
  for (std::size_t d = 0; d < lower.size(); ++d) {
    const double low = lower[d];
    widest = std::max(widest, upper[d] - low);
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
