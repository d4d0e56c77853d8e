#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <ranges>
#include <span>
#include <type_traits>
#include <variant>

#include "ccvt/types.h"

namespace ccvt {

namespace detail {

/// Numbers in memory: a contiguous range, or a vector, matrix, array or map of Eigen's.
template <class Range>
concept Numbers = requires(const std::remove_reference_t<Range>& numbers) {
  std::ranges::data(numbers);
  std::ranges::size(numbers);
};

/// Whether an argument deduced as Range&& would take its numbers along when it goes. Views, such as
/// spans and Eigen's maps, do not.
template <class Range>
constexpr bool owns_numbers() {
  if constexpr (std::is_lvalue_reference_v<Range>) {
    return false;
  } else if constexpr (requires { typename Range::PlainObject; }) {
    return std::is_same_v<typename Range::PlainObject, std::remove_cv_t<Range>>;
  } else {
    return !std::ranges::borrowed_range<Range>;
  }
}

template <class Range>
concept LastingNumbers = Numbers<Range> && !owns_numbers<Range>();
template <class Range>
concept TemporaryNumbers = Numbers<Range> && owns_numbers<Range>();

/// The numbers as they lie in memory. Throws InvalidInput for a part of an Eigen matrix that lies
/// there with gaps.
template <Numbers Range>
auto numbers_of(const Range& numbers) {
  using Value = std::remove_cvref_t<decltype(*std::ranges::data(numbers))>;
  if constexpr (requires { numbers.outerStride(); }) {
    const bool gaps = numbers.size() > 0 &&
                      (numbers.innerStride() != 1 ||
                       (numbers.outerSize() > 1 && numbers.outerStride() != numbers.innerSize()));
    if (gaps) {
      throw InvalidInput("values: this part of a matrix has gaps in memory; copy it into a matrix");
    }
  }
  return std::span<const Value>(std::ranges::data(numbers),
                                static_cast<std::size_t>(std::ranges::size(numbers)));
}

using SpanOfNumbers = std::variant<std::span<const float>, std::span<const double>,
                                   std::span<const std::int8_t>, std::span<const std::uint8_t>,
                                   std::span<const std::int16_t>, std::span<const std::uint16_t>,
                                   std::span<const std::int32_t>, std::span<const std::uint32_t>,
                                   std::span<const std::int64_t>, std::span<const std::uint64_t>>;

}  // namespace detail

/// The values of a grid where they lie, in any of the usual types: a std::vector, array or span, or
/// a vector or matrix of Eigen's, of float, double or integers of 8 to 64 bits, converts to this.
/// A view: a temporary vector is refused at compile time, since its values would be gone.
class GridValues : public detail::SpanOfNumbers {
 public:
  GridValues() = default;
  template <detail::LastingNumbers Range>
  GridValues(Range&& numbers)  // NOLINT(google-explicit-constructor): stands in for the numbers
      : detail::SpanOfNumbers(view(detail::numbers_of(numbers))) {}
  template <detail::TemporaryNumbers Range>
  GridValues(Range&& numbers) = delete;

 private:
  template <class Value>
  static std::span<const Value> view(std::span<const Value> numbers) {
    static_assert(std::constructible_from<detail::SpanOfNumbers, std::span<const Value>>,
                  "ccvt: values are float, double, or one of std::int8_t to std::uint64_t: copy "
                  "them into a vector of one of these");
    return numbers;
  }
};

/// One byte for each cell of a grid, where they lie: not 0 where the cell counts. A view, which
/// refuses temporaries as GridValues does.
class MaskView : public std::span<const std::uint8_t> {
 public:
  MaskView() = default;
  template <detail::LastingNumbers Range>
  MaskView(Range&& bytes)  // NOLINT(google-explicit-constructor): stands in for the bytes
      : std::span<const std::uint8_t>(view(detail::numbers_of(bytes))) {}
  template <detail::TemporaryNumbers Range>
  MaskView(Range&& bytes) = delete;

 private:
  template <class Value>
  static std::span<const Value> view(std::span<const Value> bytes) {
    static_assert(std::is_same_v<Value, std::uint8_t>, "ccvt: a mask is made of std::uint8_t");
    return bytes;
  }
};

}  // namespace ccvt

template <>
inline constexpr bool std::ranges::enable_borrowed_range<ccvt::MaskView> = true;
