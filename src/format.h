#pragma once

#include <charconv>
#include <string>

namespace ccvt {

/// The shortest text that reads back as `value`; std::to_string would cut it off.
inline std::string text(double value) {
  char buffer[32];
  const auto result = std::to_chars(buffer, buffer + sizeof buffer, value);
  return {buffer, result.ptr};
}

/// `value` with `digits` significant digits.
inline std::string text(double value, int digits) {
  char buffer[64];
  const auto result =
      std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::general, digits);
  return {buffer, result.ptr};
}

}  // namespace ccvt
