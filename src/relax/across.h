#pragma once

#include <algorithm>
#include <span>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "parallel/together.h"
#include "relax/filling.h"
#include "schedule/lending.h"
#include "schedule/schedule.h"
#include "schedule/tiling.h"

/// What phases do with cells that are on several ranks.
namespace ccvt {

/// Of values by site, each rank has those of its own sites: now all have all.
template <class T>
void share(const Tiling& tiling, std::vector<T>& values) {
  if (tiling.ranks() == nullptr) return;
  const NumberRange<SiteNumber> own = tiling.own_sites();
  const auto begin = values.begin() + std::ptrdiff_t((*own.begin()).index());
  values = joined(tiling.ranks(), std::vector<T>(begin, begin + std::ptrdiff_t(own.size())));
}

/// Lends cells that are being filled, where there are points left to move along an edge.
template <class Scalar>
struct FillingLender {
  Filling<Scalar>& filling;
  const Schedule& schedule;
  std::span<const std::int64_t> left;

  void add_sites(const Schedule::Task& task, Tile tile, std::vector<SiteNumber>& sites) const {
    const auto before = std::ptrdiff_t(sites.size());
    for (std::size_t e = task.begin; e < task.end; ++e) {
      if (left[e] == 0) continue;
      const auto& [i, j] = schedule.pairs[e];
      for (const SiteNumber s : {i, j}) {
        if (filling.tiles.tile_of(s) == tile) sites.push_back(s);
      }
    }
    std::sort(sites.begin() + before, sites.end());
    sites.erase(std::unique(sites.begin() + before, sites.end()), sites.end());
  }
  [[nodiscard]] bool has_work(const Schedule::Task& task) const {
    return std::any_of(left.begin() + std::ptrdiff_t(task.begin),
                       left.begin() + std::ptrdiff_t(task.end),
                       [](std::int64_t points) { return points != 0; });
  }
  [[nodiscard]] std::size_t load(const Schedule::Task& task) const { return task.size(); }
  [[nodiscard]] static bool lacks(int, SiteNumber) { return true; }
  void put(ByteWriter& message, SiteNumber site, int) { filling.write(message, site); }
  void take(ByteReader& message, SiteNumber site, int) { filling.read(message, site); }
};

/// Calls `work`, which moves points from one site to another, on the rank of the first.
template <class Scalar, class Work>
void pass_along(Filling<Scalar>& filling, SiteNumber from, SiteNumber to, const Work& work) {
  const Tiling& tiling = filling.tiles;
  if (tiling.ranks() == nullptr) return work();
  const Tile home = tiling.tile_of(from);
  const Tile other = tiling.tile_of(to);
  const auto send = [&](Tile receiver) {
    ByteWriter message;
    filling.write(message, to);
    tiling.ranks()->send(tiling.rank_of(receiver), std::move(message.bytes));
  };
  const auto receive = [&](Tile sender) {
    const Ranks::Bytes bytes = tiling.ranks()->receive(tiling.rank_of(sender));
    ByteReader message(bytes);
    filling.read(message, to);
  };
  const bool across = tiling.is_own(home) != tiling.is_own(other);
  if (across && tiling.is_own(other)) send(home);
  if (across && tiling.is_own(home)) receive(other);
  if (tiling.is_own(home)) work();
  if (across && tiling.is_own(home)) send(other);
  if (across && tiling.is_own(other)) receive(home);
}

}  // namespace ccvt
