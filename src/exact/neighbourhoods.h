#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/arena.h"

namespace ccvt {

/// Positions in groups of such as lie near each other, in a space without a torus.
struct Neighbourhoods {
  /// Groups of at most `most` positions: all are divided in two across the line between two that
  /// lie far apart, and each part again. Two thousand and more are first divided among leaders,
  /// each to the nearest, that clouds be cut less. O(n D log n), or O(n^1.5 D), for `positions` of
  /// n, one after the other. Same for any number of threads.
  Neighbourhoods(std::span<const double> positions, std::size_t dimension, std::size_t most,
                 const Arena& arena);

  [[nodiscard]] std::size_t count() const { return begin.size() - 1; }
  /// Those of a group, in no order.
  [[nodiscard]] std::span<const SiteNumber> of(std::size_t group) const {
    return std::span(order).subspan(begin[group], begin[group + 1] - begin[group]);
  }
  /// The group of each.
  [[nodiscard]] std::vector<Index> groups() const;
  /// The mean of each group, one after the other.
  [[nodiscard]] std::vector<double> means(std::span<const double> positions,
                                          std::size_t dimension) const;

  std::vector<SiteNumber> order;
  std::vector<std::size_t> begin;  ///< of each group, in `order`; and the end
};

}  // namespace ccvt
