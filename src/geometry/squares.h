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
  int d = 0;
  for (; d + kParts <= dimension; d += kParts) {
    for (int l = 0; l < kParts; ++l) {
      const double difference = static_cast<double>(a[d + l]) - static_cast<double>(b[d + l]);
      part[static_cast<std::size_t>(l)] += difference * difference;
    }
  }
  double sum =
      ((part[0] + part[4]) + (part[1] + part[5])) + ((part[2] + part[6]) + (part[3] + part[7]));
  for (; d < dimension; ++d) {
    const double difference = static_cast<double>(a[d]) - static_cast<double>(b[d]);
    sum += difference * difference;
  }
  return sum;
}

}  // namespace ccvt
