#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "parallel/loops.h"
#include "relax/filling.h"
#include "relax/nearest_sites.h"

namespace ccvt {

/// Adds points to the sites that they are near, to each in their order. A few workers look at all
/// points, each for those of its tiles; for more, though only in mind, they are grouped by tiles
/// first, with the memory of `spare`.
template <class Scalar, std::size_t Dimension>
void add_near(const Arena& arena, Buffer<Near<Scalar, Dimension>>& points,
              Buffer<Near<Scalar, Dimension>>& spare, Filling<Scalar>& filling) {
  constexpr std::size_t kFewWorkers = 4;
  constexpr std::size_t kBetweenChecks = 1 << 14;
  using Item = Near<Scalar, Dimension>;
  const Tiling& tiling = filling.tiles;
  const auto add = [&](const Item& item) {
    if constexpr (Dimension > 0) {
      filling.add(item.site, filling.points.of_all(item.point), item.x.data());
    } else {
      filling.add(item.site, item.point);
    }
  };
  const std::size_t workers = arena.workers_in_mind();
  if (workers <= kFewWorkers) {
    arena.for_each(workers, 1, [&](std::size_t w) {
      const auto first_site = [&](std::size_t worker) {
        return static_cast<std::int64_t>(tiling.count() * worker / workers) *
               tiling.sites_per_tile();
      };
      const std::int64_t begin = first_site(w);
      const std::int64_t end = first_site(w + 1);
      for (std::size_t k = 0; k < points.size(); ++k) {
        if (k % kBetweenChecks == 0) arena.check();
        const Item& item = std::as_const(points)[k];
        if (item.site.index() >= begin && item.site.index() < end) add(item);
      }
    });
    return;
  }
  auto by_tile = group_by_key(
      arena, std::move(points), tiling.count(), [](std::size_t, const Item&) {},
      [&](const Item& item) { return tiling.tile_of(item.site); }, spare);
  // Tiles in a row are one task: what is known of neighbouring sites is on the same cache lines.
  const std::size_t grain = 1 + tiling.count() / (8 * workers);
  arena.for_each(tiling.count(), grain, [&](std::size_t tile) {
    for (const Item& item : std::as_const(by_tile)[tile]) add(item);
  });
  points = std::move(by_tile.items);
}

}  // namespace ccvt
