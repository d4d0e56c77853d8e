#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
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
  Homecoming(const Tiling& tiling, Buffer<Item> items, const Arena& arena, Buffer<Item>& spare) {
    Ranks& ranks = *tiling.ranks();
    const auto count = static_cast<std::size_t>(ranks.count());
    const Groups<Item> by_rank = group_by_key(
        arena, std::move(items), count, [](std::size_t, const Item&) {},
        [&](const Item& item) {
          return static_cast<std::size_t>(tiling.rank_of(tiling.tile_of(item.site)));
        },
        spare);
    std::vector<ByteWriter> sizes(count);
    for (std::size_t r = 0; r < count; ++r) sizes[r].put(std::uint64_t{by_rank[r].size()});
    for (const Ranks::Bytes& size : exchanged(ranks, std::move(sizes))) {
      first_.push_back(first_.back() + ByteReader(size).get<std::uint64_t>());
    }
    items_ = Buffer<Item>(first_.back());
    std::vector<std::span<const std::byte>> to;
    std::vector<std::span<std::byte>> from;
    for (std::size_t r = 0; r < count; ++r) {
      to.push_back(std::as_bytes(by_rank[r]));
      from.push_back(std::as_writable_bytes(of_ranks(r, r + 1)));
    }
    ranks.exchange_parts(to, from);
    const auto own = static_cast<std::size_t>(ranks.rank());
    const std::span<const Item> stay = by_rank[own];
    std::copy(stay.begin(), stay.end(), of_ranks(own, own + 1).begin());
  }

  /// Takes those of some ranks, one rank after the other, numbered from the first point of the
  /// first.
  [[nodiscard]] Buffer<Item> take(std::size_t first, std::size_t end, const Arrivals& arrivals) {
    for (std::size_t r = first + 1; r < end; ++r) {
      const std::int64_t before = arrivals.begin_of(r).index() - arrivals.begin_of(first).index();
      for (Item& item : of_ranks(r, r + 1)) item.point = PointNumber(before + item.point.index());
    }
    if (first == 0 && end + 1 == first_.size()) return std::move(items_);
    const std::span<const Item> some = of_ranks(first, end);
    Buffer<Item> taken(some.size());
    std::copy(some.begin(), some.end(), taken.begin());
    return taken;
  }

 private:
  [[nodiscard]] std::span<Item> of_ranks(std::size_t begin, std::size_t end) {
    return items_.span().subspan(first_[begin], first_[end] - first_[begin]);
  }

  std::vector<std::size_t> first_{0};  ///< of each rank's, and the end
  Buffer<Item> items_;
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
