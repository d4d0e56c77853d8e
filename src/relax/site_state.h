#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {

/// What is known of each site while relaxing. Positions are doubles also for float points.
struct SiteState {
  SiteState() = default;
  SiteState(int dim, Index count)
      : dimension(dim),
        position(static_cast<std::size_t>(dim) * static_cast<std::size_t>(count)),
        radius(static_cast<std::size_t>(count), std::numeric_limits<double>::infinity()),
        energy(radius.size()),
        compact(radius.size()) {}

  [[nodiscard]] Index count() const { return static_cast<Index>(radius.size()); }
  [[nodiscard]] double* at(Index site) {
    return position.data() + static_cast<std::ptrdiff_t>(site) * dimension;
  }
  [[nodiscard]] const double* at(Index site) const {
    return position.data() + static_cast<std::ptrdiff_t>(site) * dimension;
  }

  int dimension = 0;
  std::vector<double> position;
  /// An upper bound on the distance from the site to the points of its cell; swaps keep it one.
  std::vector<double> radius;
  std::vector<double> energy;
  /// Whether no coordinate difference between the site and a point of its cell needs wrapping.
  std::vector<std::uint8_t> compact;
};

}  // namespace ccvt
