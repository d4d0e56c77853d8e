#pragma once

#include <array>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <span>
#include <string>
#include <string_view>

/// Numbers as text, the same in every locale.
namespace ccvt {

template <class T>
concept AnyNumber = std::integral<T> || std::floating_point<T>;

inline void append_text(std::string& text, std::string_view part) { text += part; }

/// The shortest decimal text that reads back as the same number; std::to_string would cut it off.
template <AnyNumber Number>
void append_text(std::string& text, Number value) {
  std::array<char, 64> buffer;
  text.append(buffer.data(),
              std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr);
}

/// "(1, 2.5)"; after eight numbers "…".
template <AnyNumber Number>
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

template <AnyNumber Number>
std::string text(Number value) {
  return concat(value);
}

/// `value` with `digits` significant digits, at most 40.
inline std::string text(double value, int digits) {
  std::array<char, 64> buffer;
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                    std::chars_format::general, digits);
  return {buffer.data(), result.ptr};
}

/// `value` with so many decimals, at most 40, but for zeros at the end.
inline std::string decimal_text(double value, int decimals) {
  std::array<char, 400> buffer;  // the largest double, written out
  const auto result = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value,
                                    std::chars_format::fixed, decimals);
  std::string_view shown(buffer.data(), result.ptr);
  if (shown.find('.') != std::string_view::npos) {
    shown.remove_suffix(shown.size() - 1 - shown.find_last_not_of('0'));
    if (shown.back() == '.') shown.remove_suffix(1);
  }
  return std::string(shown == "-0" ? "0" : shown);
}

}  // namespace ccvt
