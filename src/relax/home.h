#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "parallel/loops.h"
#include "parallel/together.h"
#include "relax/filling.h"
#include "relax/moved_points.h"
#include "relax/nearest_sites.h"

/// Points come to the ranks that have the cells of their sites, in the order in which one process
/// would have them.
namespace ccvt {

/// Which sites have had points once, and these of one rank, or none: they are in the order in which
/// that rank has found them.
class Arrivals {
 public:
  /// `own_begin`: the first point that may be this rank's. `end`: of all.
  Arrivals(Ranks& ranks, PointOfAll own_begin, PointOfAll end, std::size_t sites)
      : begins_(of_all(&ranks, own_begin)), count_(sites, 0) {
    begins_.push_back(end);
  }

  /// Points have come to a site, from one rank after the other.
  void add(SiteNumber site, PointOfAll first, PointOfAll last) {
    const int orders = rank_of(first) == rank_of(last) ? 1 : 2;
    count_[site] = static_cast<std::uint8_t>(std::min(count_[site] + orders, 2));
  }
  [[nodiscard]] bool in_order(SiteNumber site) const { return count_[site] < 2; }

  /// The first point that may be a rank's; of one rank more, the end.
  [[nodiscard]] PointOfAll begin_of(std::size_t rank) const { return begins_[rank]; }
  /// The end of the ranks from `rank` on that have at most so many points together, or of one.
  [[nodiscard]] std::size_t ranks_of(std::size_t rank, std::int64_t most) const {
    std::size_t end = rank + 1;
    while (end + 1 < begins_.size() && begins_[end + 1].index() - begins_[rank].index() <= most) {
      ++end;
    }
    return end;
  }

 private:
  [[nodiscard]] std::ptrdiff_t rank_of(PointOfAll point) const {
    return std::upper_bound(begins_.begin(), begins_.end(), point) - begins_.begin();
  }

  std::vector<PointOfAll> begins_;   ///< by rank, and the end
  std::vector<std::uint8_t> count_;  ///< by site; 2 for more
};

/// Points that have come to this rank from each of all, or stay, numbered by the ranks that they
/// come from.
template <class Item>
class Homecoming {
 public:
  /// Sends them to the ranks of their sites.
  Homecoming(const Tiling& tiling, Buffer<Item> items, const Arena& arena, Buffer<Item>& spare)
      : own_(static_cast<std::size_t>(tiling.ranks()->rank())) {
    const auto count = static_cast<std::size_t>(tiling.ranks()->count());
    by_rank_ = group_by_key(
        arena, std::move(items), count, [](std::size_t, const Item&) {},
        [&](const Item& item) {
          return static_cast<std::size_t>(tiling.rank_of(tiling.tile_of(item.site)));
        },
        spare);
    messages_.resize(count);
    for (std::size_t r = 0; r < count; ++r) {
      const auto bytes = std::as_bytes(std::as_const(by_rank_)[r]);
      if (r != own_) messages_[r].assign(bytes.begin(), bytes.end());
    }
    messages_ = tiling.ranks()->exchange(std::move(messages_));
  }

  /// Takes those of some ranks, one rank after the other, numbered from the first point of the
  /// first.
  [[nodiscard]] Buffer<Item> take(std::size_t first, std::size_t end, const Arrivals& arrivals) {
    std::size_t all = 0;
    for (std::size_t r = first; r < end; ++r) all += size(r);
    Buffer<Item> items(all);
    Item* next = items.data();
    for (std::size_t r = first; r < end; ++r) {
      Item* const begin = next;
      next += size(r);
      if (r == own_) {
        std::copy(by_rank_[r].begin(), by_rank_[r].end(), begin);
        by_rank_ = {};
      } else if (begin != next) {
        std::memcpy(begin, messages_[r].data(), messages_[r].size());
        messages_[r] = {};
      }
      const std::int64_t before = arrivals.begin_of(r).index() - arrivals.begin_of(first).index();
      for (Item* item = begin; item != next && before > 0; ++item) {
        item->point = PointNumber(before + item->point.index());
      }
    }
    return items;
  }

 private:
  [[nodiscard]] std::size_t size(std::size_t rank) const {
    return rank == own_ ? by_rank_[rank].size() : messages_[rank].size() / sizeof(Item);
  }

  std::size_t own_;
  Groups<Item> by_rank_;
  std::vector<Ranks::Bytes> messages_;
};

/// Adds points that have come with their coordinates, in no order. At most so many numbers are told
/// apart at once.
template <std::size_t Dimension, class Scalar>
void add_at_home(typename NearestSites<Scalar>::template Found<Dimension>& found,
                 const Arena& arena, Filling<Scalar>& filling, Arrivals& arrivals,
                 std::int64_t most = std::numeric_limits<Index>::max()) {
  using Item = Near<Scalar, Dimension>;
  Homecoming<Item> home(filling.tiles, std::move(found.points), arena, found.spare);
  const auto ranks = static_cast<std::size_t>(filling.tiles.ranks()->count());
  const NumberRange<SiteNumber> own = filling.tiles.own_sites();
  const std::size_t before = *own.begin();
  for (std::size_t first = 0; first < ranks;) {
    const std::size_t end = arrivals.ranks_of(first, most);
    const OwnPoints<Scalar> numbers({}, arrivals.begin_of(first).index());
    auto by_site = group_by_key(
        arena, home.take(first, end, arrivals), std::max(own.size(), std::size_t{1}),
        [](std::size_t, const Item&) {}, [&](const Item& item) { return item.site - before; },
        found.spare);
    for_each_site(arena, filling.tiles, [&](SiteNumber s) {
      const auto come = by_site[s - before];
      if (come.empty()) return;
      arrivals.add(s, numbers.of_all(come.front().point), numbers.of_all(come.back().point));
      for (const Item& item : come) filling.add(s, numbers.of_all(item.point), item.x.data());
    });
    found.points = std::move(by_site.items);
    first = end;
  }
}

/// Adds points that have come without: these follow.
template <class Scalar>
void add_at_home(std::span<const Near<Scalar, 0>> found, const Arena& arena,
                 Filling<Scalar>& filling) {
  MovedPoints<Scalar> moved(filling);
  for (const auto& near : found) {
    moved.send(filling.points.of_all(near.point), filling.points[near.point], near.site);
  }
  moved.arrive(arena);
}

}  // namespace ccvt
