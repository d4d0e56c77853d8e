#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/arena.h"

namespace ccvt {

/// The points grouped by site: those of site s are order[offset[s] .. offset[s + 1]), ascending.
struct Grouping {
  /// O(m + n).
  Grouping(std::span<const Index> owners, std::size_t sites, const Arena& arena = Arena(1));

  [[nodiscard]] std::size_t count() const { return offset.size() - 1; }
  [[nodiscard]] std::span<const PointNumber> of(SiteNumber site) const {
    return std::span(order).subspan(offset[site], offset[site + 1] - offset[site]);
  }

  std::vector<PointNumber> order;
  std::vector<std::size_t> offset;
};

}  // namespace ccvt
