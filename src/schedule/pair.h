#pragma once

#include <compare>
#include <concepts>
#include <cstddef>

#include "numbers.h"
#include "parallel/loops.h"

namespace ccvt {

/// Two sites.
struct Pair {
  Pair() = default;
  constexpr Pair(SiteNumber a, SiteNumber b) : first(a), second(b) {}
  constexpr explicit Pair(std::integral auto a, std::integral auto b) : first(a), second(b) {}
  friend auto operator<=>(const Pair&, const Pair&) = default;

  /// The same two, the one with the lower number first.
  [[nodiscard]] static constexpr Pair ascending(SiteNumber a, SiteNumber b) {
    return a < b ? Pair(a, b) : Pair(b, a);
  }

  SiteNumber first;
  SiteNumber second;
};

/// Pairs of so many sites by their first one, and in order.
Groups<Pair> pairs_by_first(const Arena& arena, Buffer<Pair> pairs, std::size_t sites);

/// All of these in order, each once.
Buffer<Pair> sorted_pairs(const Arena& arena, Buffer<Pair> pairs, std::size_t sites);

}  // namespace ccvt
