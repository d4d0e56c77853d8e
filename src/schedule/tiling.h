#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/ranks.h"
#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/loops.h"

namespace ccvt {

using Tile = Number<struct OfTiles>;

/// The partition of all work in the solver: tiles are runs of sites with consecutive numbers, which
/// lie close together (see spatial_order()) and have their points in one run of memory. Where
/// several ranks work, each has the cells of its own tiles, which are consecutive too.
class Tiling {
 public:
  Tiling() = default;
  Tiling(std::integral auto sites, Index sites_per_tile)
      : end_(sites),
        sites_per_tile_(std::clamp(sites_per_tile, Index{1}, std::max(end_.index(), 1))) {}

  /// Of at most `most_sites`, and of about 2^16 points: what the second cache holds.
  static Tiling of_points(Index sites, std::int64_t points, Index most_sites) {
    constexpr Index kPoints = 1 << 16;
    const auto capacity = static_cast<Index>(std::max(points / sites, std::int64_t{1}));
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

  /// The same sites, each a tile, and on the same ranks.
  [[nodiscard]] Tiling of_single_sites() const {
    Tiling ones(end_.index(), 1);
    ones.pairs_per_grain_ = pairs_per_grain_;
    if (ranks_ == nullptr) return ones;
    ones.ranks_ = ranks_;
    for (const Tile one : numbers_below<Tile>(ones.count())) {
      ones.rank_.push_back(rank_of(tile_of(SiteNumber(one.index()))));
    }
    const NumberRange<SiteNumber> own = own_sites();
    ones.own_begin_ = Tile((*own.begin()).index());
    ones.own_end_ = Tile((*own.end()).index());
    return ones;
  }

  /// Deals the tiles out to ranks, about as many points to each.
  void deal(Ranks& ranks, std::span<const Index> capacities) {
    ranks_ = &ranks;
    std::int64_t all = 0;
    for (const Index capacity : capacities) all += capacity;
    rank_.assign(count(), 0);
    std::int64_t before = 0;
    for (const Tile tile : numbers_below<Tile>(count())) {
      std::int64_t own = 0;
      for (const SiteNumber site : sites_of(tile)) own += capacities[site];
      rank_[tile] = static_cast<int>((before + own / 2) * ranks.count() / all);
      before += own;
    }
    const auto own = std::equal_range(rank_.begin(), rank_.end(), ranks.rank());
    own_begin_ = Tile(own.first - rank_.begin());
    own_end_ = Tile(own.second - rank_.begin());
  }
  /// Null where there is one.
  [[nodiscard]] Ranks* ranks() const { return ranks_; }
  [[nodiscard]] int rank_of(Tile tile) const { return rank_[tile]; }
  /// The tiles of this rank, and their sites; without ranks, all.
  [[nodiscard]] NumberRange<Tile> own_tiles() const {
    return ranks_ == nullptr ? numbers_below<Tile>(count()) : NumberRange(own_begin_, own_end_);
  }
  [[nodiscard]] NumberRange<SiteNumber> own_sites() const {
    const auto first = [this](Tile tile) {
      return SiteNumber(std::min(tile.index() * sites_per_tile_, end_.index()));
    };
    const NumberRange<Tile> own = own_tiles();
    return {first(*own.begin()), first(*own.end())};
  }
  [[nodiscard]] bool is_own(Tile tile) const {
    return ranks_ == nullptr || (own_begin_ <= tile && tile < own_end_);
  }

 private:
  static constexpr Index kPairsPerGrain = 24;  ///< of cells of a few points
  static constexpr Index kFewPoints = 256;

  SiteNumber end_{1};
  Index sites_per_tile_ = 1;
  Index pairs_per_grain_ = kPairsPerGrain;
  Ranks* ranks_ = nullptr;
  std::vector<int> rank_;  ///< by tile
  Tile own_begin_;
  Tile own_end_;
};

/// Calls body(tile, worker) for each tile of this rank, which is a task.
template <class Body>
void for_each_tile(const Arena& arena, const Tiling& tiling, const Body& body) {
  const NumberRange<Tile> own = tiling.own_tiles();
  const std::size_t first = *own.begin();
  arena.for_ranges(own.size(), 1, [&body, first](std::size_t t, std::size_t, int worker) {
    body(Tile(first + t), worker);
  });
}

/// Calls body(site) for each site of this rank, those of a tile one after the other.
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

/// What body(sites, out, worker) appends to the vector `out` for runs of `grain` of a rank's own
/// sites, one after the other.
template <class T, class Body>
Buffer<T> collect_of_own_sites(const Arena& arena, const Tiling& tiling, std::size_t grain,
                               const Body& body) {
  const NumberRange<SiteNumber> own = tiling.own_sites();
  const std::size_t first = *own.begin();
  return collect<T>(arena, own.size(), grain,
                    [&](std::size_t begin, std::size_t end, std::vector<T>& out, int worker) {
                      body(sites_between(first + begin, first + end), out, worker);
                    });
}

/// What body(site, out, worker) appends for each rank's own sites, on all ranks: for all sites, one
/// after the other.
template <class T, class Body>
Buffer<T> collect_by_site_together(const Arena& arena, const Tiling& tiling, std::size_t grain,
                                   const Body& body) {
  return found_together(
      tiling.ranks(),
      collect_of_own_sites<T>(arena, tiling, grain,
                              [&](NumberRange<SiteNumber> own, std::vector<T>& out, int worker) {
                                for (const SiteNumber site : own) body(site, out, worker);
                              }));
}

}  // namespace ccvt
