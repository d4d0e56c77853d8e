#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "parallel/together.h"
#include "relax/filling.h"
#include "relax/moved_points.h"

namespace ccvt {

/// A point that has come to one site and had left another.
struct CameFrom {
  PointOfAll point;
  SiteNumber now;
  SiteNumber before;
};

/// What a journal says of where points are and were; all between is even.
template <class Entry>
std::vector<CameFrom> moves_of(std::vector<Entry> journal) {
  std::sort(journal.begin(), journal.end(), [](const Entry& a, const Entry& b) {
    return a.point != b.point ? a.point < b.point : a.site < b.site;
  });
  std::vector<CameFrom> moves;
  for (std::size_t k = 0; k < journal.size();) {
    CameFrom own{journal[k].point, SiteNumber::none(), SiteNumber::none()};
    while (k < journal.size() && journal[k].point == own.point) {
      const SiteNumber site = journal[k].site;
      int change = 0;
      for (; k < journal.size() && journal[k].point == own.point && journal[k].site == site; ++k) {
        change += journal[k].change;
      }
      if (change > 0) own.now = site;
      if (change < 0) own.before = site;
    }
    if (own.now != SiteNumber::none()) moves.push_back(own);
  }
  return moves;
}

/// Items on the ranks that rank_of(item) says, in the order of those that they come from.
template <class Item, class RankOf>
std::vector<Item> sent(Ranks* ranks, std::vector<Item> items, const RankOf& rank_of) {
  if (ranks == nullptr) return items;
  std::vector<ByteWriter> messages(static_cast<std::size_t>(ranks->count()));
  for (const Item& item : items) messages[static_cast<std::size_t>(rank_of(item))].put(item);
  items.clear();
  for (const Ranks::Bytes& bytes : exchanged(*ranks, std::move(messages))) {
    const std::size_t before = items.size();
    items.resize(before + bytes.size() / sizeof(Item));
    ByteReader(bytes).get(std::span(items).subspan(before));
  }
  return items;
}

/// Gives back to the sites that had them when the journal was begun all points that have moved
/// since. No point waits, now or then. O(points of the cells concerned).
template <class Scalar>
void take_back(Filling<Scalar>& filling, const Arena& arena) {
  const Tiling& tiles = filling.tiles;
  // All that there is of a point comes to one rank, and where it is now to the rank of that cell.
  auto journal = sent(tiles.ranks(), filling.end_journal(), [&](const auto& entry) {
    return entry.point.index() % tiles.ranks()->count();
  });
  std::vector<CameFrom> moves =
      sent(tiles.ranks(), moves_of(std::move(journal)),
           [&](const CameFrom& own) { return tiles.rank_of(tiles.tile_of(own.now)); });
  std::sort(moves.begin(), moves.end(), [](const CameFrom& a, const CameFrom& b) {
    return a.now != b.now ? a.now < b.now : a.point < b.point;
  });
  MovedPoints<Scalar> moved(filling);
  for (auto own = moves.begin(); own != moves.end();) {
    const SiteNumber now = own->now;
    const auto end =
        std::find_if(own, moves.end(), [&](const CameFrom& m) { return m.now != now; });
    for (Index k = filling.filled[now]; k-- > 0;) {
      const PointOfAll point = filling.cells.point(now, k);
      const auto at = std::lower_bound(own, end, point,
                                       [](const CameFrom& m, PointOfAll p) { return m.point < p; });
      if (at != end && at->point == point) moved.take(now, k, at->before);
    }
    own = end;
  }
  moved.arrive(arena);
}

}  // namespace ccvt
