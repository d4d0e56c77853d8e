#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace ccvt {

inline void append_text(std::string& text, std::string_view part) { text += part; }

/// A number as the shortest decimal text that reads back as the same number.
template <class Number>
requires std::integral<Number> || std::floating_point<Number>
void append_text(std::string& text, Number value) {
  std::array<char, 64> buffer{};
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  text.append(buffer.data(), result.ptr);
}

/// "(1, 2.5)"; after eight numbers "…".
template <class Number>
void append_text(std::string& text, std::span<Number> values) {
  text += '(';
  for (std::size_t i = 0; i < values.size() && i < 8; ++i) {
    if (i > 0) text += ", ";
    append_text(text, values[i]);
  }
  text += values.size() > 8 ? ", …)" : ")";
}

/// The parts, strung together.
template <class... Parts>
std::string concat(const Parts&... parts) {
  std::string result;
  (append_text(result, parts), ...);
  return result;
}

}  // namespace ccvt
