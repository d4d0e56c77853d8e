#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>

#include "ccvt/types.h"

namespace ccvt {

/// A tile, by its number.
struct Tile {
  Index number = 0;
  friend auto operator<=>(const Tile&, const Tile&) = default;
};

/// The partition of all work in the solver: tiles are runs of sites with consecutive numbers, which
/// lie close together (see spatial_order()) and have their points in one run of memory.
class Tiling {
 public:
  Tiling() = default;
  Tiling(Index sites, Index sites_per_tile)
      : sites_(sites), sites_per_tile_(std::clamp(sites_per_tile, Index{1}, std::max(sites, 1))) {}

  /// Of at most `most_sites`, and of about 2^16 points: what the second cache holds.
  static Tiling of_points(Index sites, Index points, Index most_sites) {
    constexpr Index kPoints = 1 << 16;
    const Index capacity = std::max(points / sites, 1);
    return {sites, std::min(most_sites, kPoints / capacity)};
  }

  [[nodiscard]] Index sites() const { return sites_; }
  [[nodiscard]] Index sites_per_tile() const { return sites_per_tile_; }
  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>((sites_ - 1) / sites_per_tile_) + 1;
  }
  [[nodiscard]] Tile tile_of(Index site) const { return {site / sites_per_tile_}; }
  /// The sites of a tile are those from begin(tile) to end(tile) - 1.
  [[nodiscard]] Index begin(Tile tile) const { return tile.number * sites_per_tile_; }
  [[nodiscard]] Index end(Tile tile) const {
    const Index from = begin(tile);
    return sites_ - from > sites_per_tile_ ? from + sites_per_tile_ : sites_;
  }

 private:
  Index sites_ = 1;
  Index sites_per_tile_ = 1;
};

}  // namespace ccvt
