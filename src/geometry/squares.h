#pragma once

#include <array>
#include <cstddef>

namespace ccvt {

/// |a - b|^2 in double, by eight interleaved sums: the same bits everywhere, and fast in many
/// dimensions.
template <class A, class B>
double squared_difference(const A* a, const B* b, int dimension) {
  constexpr int kParts = 8;
  std::array<double, kParts> part{};
  for (; dimension >= kParts; dimension -= kParts, a += kParts, b += kParts) {
    for (std::size_t l = 0; l < part.size(); ++l) {
      const double to = a[l];
      const double difference = to - b[l];
      part[l] += difference * difference;
    }
  }
  double sum =
      ((part[0] + part[4]) + (part[1] + part[5])) + ((part[2] + part[6]) + (part[3] + part[7]));
  for (int d = 0; d < dimension; ++d) {
    const double to = a[d];
    const double difference = to - b[d];
    sum += difference * difference;
  }
  return sum;
}

}  // namespace ccvt
