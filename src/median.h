#pragma once

#include <algorithm>
#include <iterator>
#include <span>

namespace ccvt {

/// Of some values, whose order it changes: the upper one of two.
inline double median(std::span<double> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace ccvt
