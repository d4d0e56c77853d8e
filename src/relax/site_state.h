#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "numbers.h"

namespace ccvt {

/// What is known of each site while relaxing. Positions are doubles also for float points.
struct SiteState {
  SiteState() = default;
  SiteState(std::integral auto dimensions, std::integral auto sites)
      : dimension(static_cast<std::size_t>(dimensions)),
        radius(static_cast<std::size_t>(sites), std::numeric_limits<double>::infinity()),
        energy(radius.size()),
        compact(radius.size()) {
    position.resize(dimension * radius.size());
  }

  [[nodiscard]] std::size_t count() const { return radius.size(); }
  [[nodiscard]] NumberRange<SiteNumber> all() const { return sites_below(count()); }
  [[nodiscard]] double* at(SiteNumber site) { return position.data() + site * dimension; }
  [[nodiscard]] const double* at(SiteNumber site) const {
    return position.data() + site * dimension;
  }

  std::size_t dimension = 0;
  std::vector<double> position;
  /// An upper bound on the distance from the site to the points of its cell; swaps keep it one.
  std::vector<double> radius;
  std::vector<double> energy;
  /// Whether no coordinate difference between the site and a point of its cell needs wrapping.
  std::vector<std::uint8_t> compact;
  /// Whether the site stays where it is; empty where none does.
  std::vector<std::uint8_t> fixed;

  [[nodiscard]] bool is_fixed(SiteNumber site) const { return !fixed.empty() && fixed[site] != 0; }
};

}  // namespace ccvt
