#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <vector>

#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/loops.h"

namespace ccvt {

using Tile = Number<struct OfTiles>;

/// The partition of all work in the solver: tiles are runs of sites with consecutive numbers, which
/// lie close together (see spatial_order()) and have their points in one run of memory.
class Tiling {
 public:
  Tiling() = default;
  Tiling(std::integral auto sites, Index sites_per_tile)
      : end_(sites),
        sites_per_tile_(std::clamp(sites_per_tile, Index{1}, std::max(end_.index(), 1))) {}

  /// Of at most `most_sites`, and of about 2^16 points: what the second cache holds.
  static Tiling of_points(Index sites, Index points, Index most_sites) {
    constexpr Index kPoints = 1 << 16;
    const Index capacity = std::max(points / sites, 1);
    Tiling tiling(sites, std::min(most_sites, kPoints / capacity));
    tiling.pairs_per_grain_ = std::clamp(kPairsPerGrain * kFewPoints / capacity, 1, kPairsPerGrain);
    return tiling;
  }

  [[nodiscard]] std::size_t sites() const { return end_; }
  [[nodiscard]] Index sites_per_tile() const { return sites_per_tile_; }
  /// Pairs of sites beside whose work the start of a task is negligible.
  [[nodiscard]] std::size_t pairs_per_grain() const {
    return static_cast<std::size_t>(pairs_per_grain_);
  }
  [[nodiscard]] std::size_t count() const { return tile_of(SiteNumber(end_ - 1)) + 1; }
  [[nodiscard]] Tile tile_of(SiteNumber site) const { return Tile(site.index() / sites_per_tile_); }
  [[nodiscard]] NumberRange<SiteNumber> sites_of(Tile tile) const {
    const Index begin = tile.index() * sites_per_tile_;
    return {SiteNumber(begin), SiteNumber(begin + std::min(sites_per_tile_, end_.index() - begin))};
  }

 private:
  static constexpr Index kPairsPerGrain = 24;  ///< of cells of a few points
  static constexpr Index kFewPoints = 256;

  SiteNumber end_{1};
  Index sites_per_tile_ = 1;
  Index pairs_per_grain_ = kPairsPerGrain;
};

/// Calls body(tile, worker) for each tile, which is a task.
template <class Body>
void for_each_tile(const Arena& arena, const Tiling& tiling, const Body& body) {
  arena.for_ranges(tiling.count(), 1,
                   [&body](std::size_t t, std::size_t, int worker) { body(Tile(t), worker); });
}

/// Calls body(site) for each site, those of a tile one after the other.
template <class Body>
void for_each_site(const Arena& arena, const Tiling& tiling, const Body& body) {
  for_each_tile(arena, tiling, [&](Tile tile, int) {
    for (const SiteNumber site : tiling.sites_of(tile)) body(site);
  });
}

/// Calls body(site) for each of so many, `grain` of them a task.
template <class Body>
void for_each_site(const Arena& arena, std::size_t sites, std::size_t grain, const Body& body) {
  arena.for_each(sites, grain, [&body](std::size_t s) { body(SiteNumber(s)); });
}

/// What body(site, out, worker) appends to the vector `out`, one site after the other.
template <class T, class Body>
Buffer<T> collect_by_site(const Arena& arena, std::size_t sites, std::size_t grain,
                          const Body& body) {
  return collect<T>(arena, sites, grain,
                    [&](std::size_t begin, std::size_t end, std::vector<T>& out, int worker) {
                      for (const SiteNumber site : sites_between(begin, end)) {
                        body(site, out, worker);
                      }
                    });
}

}  // namespace ccvt
