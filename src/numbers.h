#pragma once

#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <iterator>

#include "ccvt/types.h"

namespace ccvt {

/// The number of one of many things of a kind, from 0. Arrays are indexed by it as it is; numbers
/// of different kinds, and plain integers, do not become each other unless asked to.
template <class Kind, std::signed_integral Value = Index>
class Number {
 public:
  constexpr Number() = default;
  template <std::integral Integer>
  constexpr explicit Number(Integer value) : value_(static_cast<Value>(value)) {}

  /// The number of nothing: no array has it.
  [[nodiscard]] static constexpr Number none() { return Number(-1); }

  [[nodiscard]] constexpr Value index() const { return value_; }
  [[nodiscard]] constexpr Number next() const { return Number(value_ + 1); }
  constexpr operator std::size_t() const { return static_cast<std::size_t>(value_); }

  constexpr Number& operator++() {
    ++value_;
    return *this;
  }
  friend constexpr bool operator==(Number a, Number b) { return a.value_ == b.value_; }
  friend constexpr auto operator<=>(Number a, Number b) { return a.value_ <=> b.value_; }

 private:
  Value value_ = 0;
};

using SiteNumber = Number<struct OfSites>;
/// Of a point of this process.
using PointNumber = Number<struct OfPoints>;
/// Of a point among those of all ranks, which follow each other's: without ranks the same.
using PointOfAll = Number<struct OfAllPoints, std::int64_t>;
constexpr std::int64_t kMostPointsOfAll = std::int64_t{1} << 40;

/// The numbers from `begin` to `end` - 1, for range-based loops.
template <class N>
class NumberRange {
 public:
  class Iterator {
   public:
    using value_type = N;
    using difference_type = std::ptrdiff_t;
    constexpr explicit Iterator(N number) : number_(number) {}
    constexpr N operator*() const { return number_; }
    constexpr Iterator& operator++() {
      ++number_;
      return *this;
    }
    friend constexpr bool operator==(Iterator, Iterator) = default;

   private:
    N number_;
  };

  constexpr NumberRange(N begin, N end) : begin_(begin), end_(end) {}
  [[nodiscard]] constexpr Iterator begin() const { return Iterator(begin_); }
  [[nodiscard]] constexpr Iterator end() const { return Iterator(end_); }
  [[nodiscard]] constexpr std::size_t size() const { return end_ - begin_; }
  /// Those after one of them.
  [[nodiscard]] constexpr NumberRange after(N number) const { return {number.next(), end_}; }

 private:
  N begin_;
  N end_;
};

template <class Number>
NumberRange<Number> numbers_below(std::integral auto count) {
  return {Number(0), Number(count)};
}
inline NumberRange<SiteNumber> sites_between(std::integral auto begin, std::integral auto end) {
  return {SiteNumber(begin), SiteNumber(end)};
}
inline NumberRange<SiteNumber> sites_below(std::integral auto count) {
  return {SiteNumber(0), SiteNumber(count)};
}
inline NumberRange<PointNumber> points_below(std::integral auto count) {
  return {PointNumber(0), PointNumber(count)};
}

}  // namespace ccvt
