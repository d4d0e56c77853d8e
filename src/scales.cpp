#include "scales.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "geometry/coordinate_range.h"
#include "number_text.h"

namespace ccvt {

template <class Scalar>
double require_moderate(const char* argument, const PointsView<Scalar>& points, const Arena& arena,
                        std::int64_t first_number) {
  const double largest = largest_coordinate<Scalar>(points.dimension);
  if (points.count == 0) return 0;
  const CoordinateRange<Scalar> range = coordinate_range(points, arena);
  bool moderate = range.ordered;
  double widest = 0;
  for (std::size_t d = 0; d < range.lower.size(); ++d) {
    const double low = range.lower[d];
    moderate = moderate && low >= -largest && range.upper[d] <= largest;
    widest = std::max(widest, range.upper[d] - low);
  }
  if (moderate) return widest;
  for (Index p = 0; p < points.count; ++p) {
    for (std::size_t d = 0; d < range.lower.size(); ++d) {
      const double value = points[p][d];
      if (std::abs(value) <= largest) continue;
      throw InvalidInput(std::string(argument) + ": coordinate " + std::to_string(d) + " of " +
                         argument + "[" + std::to_string(first_number + p) + "] is " + text(value) +
                         ": coordinates must be finite and at most " + text(largest) +
                         " in magnitude");
    }
  }
  return widest;
}

template <class Scalar>
void require_extent(const char* argument, double widest) {
  if (widest == 0 || widest >= kSmallestExtent<Scalar>) return;
  throw InvalidInput(std::string(argument) + ": their coordinates differ by at most " +
                     text(widest) + ": they must be all equal or differ by " +
                     text(kSmallestExtent<Scalar>) +
                     " or more somewhere; multiply them by a power of two");
}

template <class Scalar>
void require_scale(const char* argument, const PointsView<Scalar>& points, const Arena& arena) {
  require_extent<Scalar>(argument, require_moderate(argument, points, arena));
}

template double require_moderate(const char*, const PointsView<float>&, const Arena&, std::int64_t);
template double require_moderate(const char*, const PointsView<double>&, const Arena&,
                                 std::int64_t);
template void require_extent<float>(const char*, double);
template void require_extent<double>(const char*, double);
template void require_scale(const char*, const PointsView<float>&, const Arena&);
template void require_scale(const char*, const PointsView<double>&, const Arena&);

}  // namespace ccvt
