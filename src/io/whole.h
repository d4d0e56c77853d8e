#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <utility>

namespace ccvt::io {

/// The whole number that a number of any type is. Sets it and returns nullptr, or returns what is
/// wrong with the number.
template <class Number>
const char* to_whole(Number number, std::int32_t& whole) {
  constexpr const char* kWide = "does not fit 32 bits";
  if constexpr (std::floating_point<Number>) {
    if (number != std::trunc(number)) return "is not a whole number";  // NaN neither
    if (number < -0x1p31 || number >= 0x1p31) return kWide;
  } else {
    if (!std::in_range<std::int32_t>(number)) return kWide;
  }
  whole = static_cast<std::int32_t>(number);
  return nullptr;
}

}  // namespace ccvt::io
