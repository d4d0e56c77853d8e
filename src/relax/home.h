#pragma once

#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "parallel/loops.h"
#include "relax/filling.h"
#include "relax/nearest_sites.h"

namespace ccvt {

/// Adds points that ranks have found the nearest sites of to the cells of these, each on the rank
/// that has the cell, in the order in which one process would.
template <std::size_t Dimension, class Scalar>
void add_at_home(const NearestSites<Scalar>& nearest,
                 std::span<const Near<Scalar, Dimension>> found, const Arena& arena,
                 Filling<Scalar>& filling) {
  const Tiling& tiling = filling.tiles;
  const std::size_t dimension = filling.cells.dimension();
  std::vector<ByteWriter> messages(static_cast<std::size_t>(tiling.ranks()->count()));
  for (const auto& near : found) {
    ByteWriter& message = messages[static_cast<std::size_t>(tiling.rank_of(tiling.tile_of(near.site)))];
    message.put(near.site);
    message.put(near.point);
    message.put(std::span(filling.points[near.point.index()], dimension));
  }
  std::vector<Ranks::Bytes> bytes;
  for (ByteWriter& message : messages) bytes.push_back(std::move(message.bytes));

  struct Arrived {
    SiteNumber site;
    PointNumber point;
    std::size_t cell;  // of the grid
    std::size_t x;     // where its coordinates are
  };
  std::vector<Arrived> arrived;
  std::vector<Scalar> x;
  for (const Ranks::Bytes& message : tiling.ranks()->exchange(std::move(bytes))) {
    ByteReader reader(message);
    while (!reader.done()) {
      const auto site = reader.get<SiteNumber>();
      const auto point = reader.get<PointNumber>();
      x.resize(x.size() + dimension);
      Scalar* const own = x.data() + x.size() - dimension;
      reader.get(std::span(own, dimension));
      arrived.push_back({site, point, Dimension > 0 ? nearest.cell_of(own) : 0, x.size() - dimension});
    }
  }
  // Ranks' points come in the order of their numbers: where there is no grid, all is in order.
  if (Dimension > 0) {
    std::stable_sort(arrived.begin(), arrived.end(),
                     [](const Arrived& a, const Arrived& b) { return a.cell < b.cell; });
  }
  const auto by_site = group_by_key<Arrived>(
      arena, arrived.size(), filling.cells.site_count(),
      [&](std::size_t k) { return arrived[k]; }, [](const Arrived& a) { return a.site; });
  for_each_site(arena, tiling, [&](SiteNumber s) {
    for (const Arrived& a : by_site[s]) filling.add(s, a.point, x.data() + a.x);
  });
}

}  // namespace ccvt
