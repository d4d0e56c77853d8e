#pragma once

#include <span>
#include <utility>
#include <vector>

#include "schedule/schedule.h"

namespace ccvt {

/// Every pair of sites: first those inside tiles, then the rounds of a tournament between tiles
/// [4.3, Program 5, full stage]. Read like a Schedule, but made batch by batch.
class AllPairs {
 public:
  explicit AllPairs(Tiling tiling) : tiling_(std::move(tiling)) {}

  [[nodiscard]] std::size_t batch_count() const { return tiling_.count() + 1; }

  /// Valid until the next call.
  [[nodiscard]] std::span<const Schedule::Task> batch(std::size_t b) {
    tasks_.clear();
    if (b > 0) {
      round_robin(tiling_.count(), b - 1,
                  [&](std::size_t t, std::size_t u) { add(Tile(t), Tile(u)); });
    } else if (tiling_.sites_per_tile() > 1) {
      for (const Tile tile : numbers_below<Tile>(tiling_.count())) add(tile, tile);
    }
    return tasks_;
  }

  template <class Visit>
  void for_pairs(const Schedule::Task& task, const Visit& visit) const {
    const auto others = tiling_.sites_of(task.b);
    for (const SiteNumber i : tiling_.sites_of(task.a)) {
      for (const SiteNumber j : task.a == task.b ? others.after(i) : others) visit(i, j);
    }
  }

 private:
  void add(Tile t, Tile u) {
    tasks_.push_back({t, u, 0, tiling_.sites_of(t).size() * tiling_.sites_of(u).size()});
  }

  Tiling tiling_;
  std::vector<Schedule::Task> tasks_;
};

}  // namespace ccvt
