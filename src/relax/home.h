#pragma once

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "parallel/loops.h"
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

/// Adds points that have come with their coordinates, in no order.
template <std::size_t Dimension, class Scalar>
void add_at_home(typename NearestSites<Scalar>::template Found<Dimension>& found,
                 const Arena& arena, Filling<Scalar>& filling) {
  using Item = Near<Scalar, Dimension>;
  auto by_site = group_by_key(
      arena, sent_home(filling.tiles, std::move(found.points), arena, found.spare),
      filling.cells.site_count(), [](std::size_t, const Item&) {},
      [](const Item& item) { return item.site; }, found.spare);
  for_each_site(arena, filling.tiles, [&](SiteNumber s) {
    for (const Item& item : by_site[s]) filling.add(s, item.point, item.x.data());
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
