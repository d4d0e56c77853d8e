#pragma once

#include <cstddef>
#include <utility>

#include "parallel/loops.h"
#include "relax/filling.h"
#include "relax/nearest_sites.h"

namespace ccvt {

/// Adds points to the sites that they are near, to each in their order. For several workers they
/// are grouped by tiles first, with the memory of `spare`.
template <class Scalar, std::size_t Dimension>
void add_near(const Arena& arena, Buffer<Near<Scalar, Dimension>>& points,
              Buffer<Near<Scalar, Dimension>>& spare, Filling<Scalar>& filling) {
  using Item = Near<Scalar, Dimension>;
  const auto add = [&](std::span<const Item> items) {
    for (const Item& item : items) {
      if constexpr (Dimension > 0) {
        filling.add(item.site, filling.points.of_all(item.point), item.x.data());
      } else {
        filling.add(item.site, item.point);
      }
    }
  };
  if (!arena.prepares()) return add(points.span());
  const Tiling& tiling = filling.tiles;
  auto by_tile = group_by_key(
      arena, std::move(points), tiling.count(), [](std::size_t, const Item&) {},
      [&](const Item& item) { return tiling.tile_of(item.site); }, spare);
  for_each_tile(arena, tiling, [&](Tile tile, int) { add(by_tile[tile]); });
  points = std::move(by_tile.items);
}

}  // namespace ccvt
