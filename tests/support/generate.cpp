#include "support/generate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "random.h"

namespace ccvt::test {

const char* name_of(Layout layout) {
  switch (layout) {
    case Layout::random:
      return "random";
    case Layout::grid:
      return "grid";
    case Layout::clusters:
      return "clusters";
    case Layout::duplicates:
      return "duplicates";
    case Layout::two_places:
      return "two places";
    case Layout::one_place:
      return "one place";
  }
  return "?";
}

Box uneven_box(int dimension) {
  Box box = Box::unit(dimension);
  for (int d = 0; d < dimension; ++d) {
    box.lower[d] = -2.5 + 0.75 * (d % 6);
    box.upper[d] = box.lower[d] + 1.25 + 0.5 * (d % 4);
  }
  return box;
}

template <class Scalar>
Points<Scalar> make_points(Layout layout, const Box& box, Index count, std::uint64_t seed) {
  const int dimension = box.dimension();
  Random random(seed, static_cast<std::uint64_t>(layout) + 100);
  Points<Scalar> points(dimension, count);
  const auto place = [&](Index p, int d, double u) {
    const double x = box.lower[d] + u * (box.upper[d] - box.lower[d]);
    points(d, p) = static_cast<Scalar>(std::clamp(x, box.lower[d], box.upper[d]));
  };
  const auto copy = [&](Index from, Index to) { points.col(to) = points.col(from); };
  const auto side =
      std::max<Index>(2, static_cast<Index>(std::ceil(std::pow(count, 1.0 / dimension) - 1e-9)));
  std::vector<double> centre(static_cast<std::size_t>(5 * dimension));
  for (double& c : centre) c = 0.1 + 0.8 * random.uniform();

  for (Index p = 0; p < count; ++p) {
    Index rest = p;
    for (int d = 0; d < dimension; ++d) {
      switch (layout) {
        case Layout::grid:
          place(p, d, static_cast<double>(rest % side) / side);
          rest /= side;
          break;
        case Layout::clusters: {
          const double middle = centre[static_cast<std::size_t>((p % 5) * dimension + d)];
          place(p, d, middle + 0.01 * (random.uniform() + random.uniform() - 1));
          break;
        }
        default:
          place(p, d, random.uniform());
      }
    }
    if (layout == Layout::duplicates && p % 7 != 0) copy(p - p % 7, p);
    if (layout == Layout::two_places && p > 1) copy(p % 3 == 0 ? 0 : 1, p);
    if (layout == Layout::one_place && p > 0) copy(0, p);
  }
  return points;
}

template Points<float> make_points(Layout, const Box&, Index, std::uint64_t);
template Points<double> make_points(Layout, const Box&, Index, std::uint64_t);

std::vector<Index> unequal_capacities(Index sites, std::uint64_t seed) {
  Random random(seed, 99);
  std::vector<Index> capacities(static_cast<std::size_t>(sites), 1);
  for (std::size_t s = 1; s < capacities.size(); ++s) {
    capacities[s] =
        1 + static_cast<Index>(std::pow(100.0, random.uniform() * random.uniform())) / 2;
  }
  capacities.back() = 1000;
  return capacities;
}

Index sum_of(const std::vector<Index>& capacities) {
  return std::accumulate(capacities.begin(), capacities.end(), Index{0});
}

}  // namespace ccvt::test
