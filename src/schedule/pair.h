#pragma once

#include <compare>
#include <cstddef>

#include "ccvt/types.h"
#include "parallel/loops.h"

namespace ccvt {

/// Two nodes of a graph: sites, where nothing else is said.
struct Pair {
  Pair() = default;
  constexpr Pair(Index a, Index b) : first(a), second(b) {}
  friend auto operator<=>(const Pair&, const Pair&) = default;

  Index first;
  Index second;
};

/// Pairs of nodes < `nodes` by their first one, and in order.
Groups<Pair> pairs_by_first(const Arena& arena, Buffer<Pair> pairs, std::size_t nodes);

/// All of these in order, each once.
Buffer<Pair> sorted_pairs(const Arena& arena, Buffer<Pair> pairs, std::size_t nodes);

}  // namespace ccvt
