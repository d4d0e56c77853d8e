#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>

#include "number_text.h"

namespace ccvt::cli {

/// What a number on the command line must be.
template <class Number>
struct Range {
  Number least = std::numeric_limits<Number>::lowest();
  Number most = std::numeric_limits<Number>::max();
  bool open_below = false;  ///< `least` itself is out
  bool open_above = false;  ///< `most` itself is out
};

template <class Number>
std::string describe(const Range<Number>& range, bool too_large) {
  std::string text = std::is_integral_v<Number> ? "a whole number" : "a finite number";
  const bool least =
      std::is_unsigned_v<Number> || range.least != std::numeric_limits<Number>::lowest();
  const bool most = too_large || range.most != std::numeric_limits<Number>::max();
  if (least) text += (range.open_below ? " above " : " of at least ") + concat(range.least);
  if (most) {
    text += least ? " and" : "";
    text += (range.open_above ? " below " : " at most ") + concat(range.most);
  }
  return text;
}

/// Parses all of `text`, in plain decimal notation whatever the locale. Returns what is wrong with
/// it, or nothing.
template <class Number>
std::string parse_number(std::string_view text, const Range<Number>& range, Number& value) {
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  bool good = error == std::errc() && stop == end && value >= range.least && value <= range.most &&
              !(range.open_below && value == range.least) &&
              !(range.open_above && value == range.most);
  if constexpr (!std::is_integral_v<Number>) good = good && std::isfinite(value);
  if (good) return {};
  const bool too_large = error == std::errc::result_out_of_range && text.front() != '-';
  return "'" + std::string(text) + "' is not " + describe(range, too_large);
}

/// The letters of UTF-8 text, not its bytes.
inline std::size_t width_of(std::string_view text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  }));
}

}  // namespace ccvt::cli
