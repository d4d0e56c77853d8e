#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
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

/// Sends items to the ranks of their sites; what has come, with what stays, in the order of ranks.
template <class Item>
Buffer<Item> sent_home(const Tiling& tiling, Buffer<Item> items, const Arena& arena,
                       Buffer<Item>& spare) {
  const auto count = static_cast<std::size_t>(tiling.ranks()->count());
  const auto own = static_cast<std::size_t>(tiling.ranks()->rank());
  auto by_rank = group_by_key(
      arena, std::move(items), count, [](std::size_t, const Item&) {},
      [&](const Item& item) {
        return static_cast<std::size_t>(tiling.rank_of(tiling.tile_of(item.site)));
      },
      spare);
  std::vector<Ranks::Bytes> messages(count);
  std::size_t all = by_rank[own].size();
  for (std::size_t r = 0; r < count; ++r) {
    const auto bytes = std::as_bytes(std::as_const(by_rank)[r]);
    if (r != own) messages[r].assign(bytes.begin(), bytes.end());
  }
  messages = tiling.ranks()->exchange(std::move(messages));
  for (const Ranks::Bytes& message : messages) all += message.size() / sizeof(Item);
  Buffer<Item> home(all);
  Item* next = home.data();
  for (std::size_t r = 0; r < count; ++r) {
    if (r == own) {
      next = std::copy(by_rank[r].begin(), by_rank[r].end(), next);
    } else if (!messages[r].empty()) {
      std::memcpy(next, messages[r].data(), messages[r].size());
      next += messages[r].size() / sizeof(Item);
    }
  }
  return home;
}

/// Which sites have had points once, and these of one rank, or none: they are in the order in which
/// that rank has found them.
class Arrivals {
 public:
  /// `own_begin`: the first point that may be this rank's.
  Arrivals(Ranks& ranks, PointNumber own_begin, std::size_t sites)
      : begins_(of_all(&ranks, own_begin)), count_(sites, 0) {}

  /// Points have come to a site, from one rank after the other.
  void add(SiteNumber site, PointNumber first, PointNumber last) {
    const int orders = rank_of(first) == rank_of(last) ? 1 : 2;
    count_[site] = static_cast<std::uint8_t>(std::min(count_[site] + orders, 2));
  }
  [[nodiscard]] bool in_order(SiteNumber site) const { return count_[site] < 2; }

 private:
  [[nodiscard]] std::ptrdiff_t rank_of(PointNumber point) const {
    return std::upper_bound(begins_.begin(), begins_.end(), point) - begins_.begin();
  }

  std::vector<PointNumber> begins_;  ///< by rank
  std::vector<std::uint8_t> count_;  ///< by site; 2 for more
};

/// Adds points that have come with their coordinates, in no order.
template <std::size_t Dimension, class Scalar>
void add_at_home(typename NearestSites<Scalar>::template Found<Dimension>& found,
                 const Arena& arena, Filling<Scalar>& filling, Arrivals& arrivals) {
  using Item = Near<Scalar, Dimension>;
  auto by_site = group_by_key(
      arena, sent_home(filling.tiles, std::move(found.points), arena, found.spare),
      filling.cells.site_count(), [](std::size_t, const Item&) {},
      [](const Item& item) { return item.site; }, found.spare);
  for_each_site(arena, filling.tiles, [&](SiteNumber s) {
    const auto come = by_site[s];
    if (!come.empty()) arrivals.add(s, come.front().point, come.back().point);
    for (const Item& item : come) filling.add(s, item.point, item.x.data());
  });
  found.points = std::move(by_site.items);
}

/// Adds points that have come without: these follow.
template <class Scalar>
void add_at_home(std::span<const Near<Scalar, 0>> found, const Arena& arena,
                 Filling<Scalar>& filling) {
  MovedPoints<Scalar> moved(filling);
  for (const auto& near : found) {
    moved.send(near.point, filling.points[near.point.index()], near.site);
  }
  moved.arrive(arena);
}

}  // namespace ccvt
