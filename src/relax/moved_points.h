#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "parallel/loops.h"
#include "parallel/together.h"
#include "relax/filling.h"

namespace ccvt {

/// Points on their way to sites, perhaps to those of other ranks.
template <class Scalar>
class MovedPoints {
 public:
  explicit MovedPoints(Filling<Scalar>& filling)
      : filling_(filling),
        x_(filling.cells.dimension()),
        to_(ranks() == nullptr ? 1 : static_cast<std::size_t>(ranks()->count())) {}

  /// Takes the point at place k out of a cell of this rank.
  void take(SiteNumber from, Index k, SiteNumber to) {
    filling_.cells.get(from, k, x_.data());
    send(filling_.take(from, k), x_.data(), to);
  }

  /// A point that is in no cell, at `x`.
  void send(PointOfAll point, const Scalar* x, SiteNumber to) {
    const Tiling& tiles = filling_.tiles;
    const int rank = ranks() == nullptr ? 0 : tiles.rank_of(tiles.tile_of(to));
    ByteWriter& message = to_[static_cast<std::size_t>(rank)];
    message.put(to);
    message.put(point);
    message.put(std::span(x, x_.size()));
  }

  /// Adds them to their sites, in the order in which they were sent, those of lower ranks first.
  void arrive(const Arena& arena) {
    std::vector<ByteWriter> sent = std::exchange(to_, {});
    std::vector<Ranks::Bytes> messages;
    if (ranks() != nullptr) {
      messages = exchanged(*ranks(), std::move(sent));
    } else {
      messages.push_back(std::move(sent.front().bytes));
    }
    struct Arrived {
      SiteNumber site;
      PointOfAll point;
      std::size_t x;  // where its coordinates are
    };
    std::vector<Arrived> arrived;
    std::vector<Scalar> x;
    for (const Ranks::Bytes& message : messages) {
      ByteReader reader(message);
      while (!reader.done()) {
        const auto site = reader.get<SiteNumber>();
        arrived.push_back({site, reader.get<PointOfAll>(), x.size()});
        x.resize(x.size() + x_.size());
        reader.get(std::span(x).last(x_.size()));
      }
    }
    const auto by_site = group_by_key<Arrived>(
        arena, arrived.size(), filling_.cells.site_count(),
        [&](std::size_t k) { return arrived[k]; }, [](const Arrived& a) { return a.site; });
    for_each_site(arena, filling_.tiles, [&](SiteNumber s) {
      for (const Arrived& a : by_site[s]) filling_.add(s, a.point, x.data() + a.x);
    });
  }

 private:
  [[nodiscard]] Ranks* ranks() const { return filling_.tiles.ranks(); }

  Filling<Scalar>& filling_;
  std::vector<Scalar> x_;
  std::vector<ByteWriter> to_;  ///< by rank
};

}  // namespace ccvt
