#pragma once

#include <span>
#include <vector>

#include "schedule/schedule.h"

namespace ccvt {

/// Every pair of sites: first those inside tiles, then the rounds of a tournament between tiles
/// [4.3, Program 5, full stage]. Read like a Schedule, but made batch by batch.
class AllPairs {
 public:
  explicit AllPairs(const Tiling& tiling) : tiling_(tiling) {}

  [[nodiscard]] std::size_t batch_count() const { return tiling_.count() + 1; }

  /// Valid until the next call.
  [[nodiscard]] std::span<const Schedule::Task> batch(std::size_t b) {
    tasks_.clear();
    const auto tiles = static_cast<Index>(tiling_.count());
    if (b == 0) {
      for (Index t = 0; t < tiles && tiling_.sites_per_tile() > 1; ++t) add({t}, {t});
    } else {
      round_robin(tiles, static_cast<Index>(b) - 1, [&](Index t, Index u) { add({t}, {u}); });
    }
    return tasks_;
  }

  template <class Visit>
  void for_pairs(const Schedule::Task& task, const Visit& visit) const {
    for (Index i = tiling_.begin(task.a); i < tiling_.end(task.a); ++i) {
      for (Index j = task.a == task.b ? i + 1 : tiling_.begin(task.b); j < tiling_.end(task.b);
           ++j) {
        visit(i, j);
      }
    }
  }

 private:
  void add(Tile t, Tile u) {
    const auto sites = [&](Tile tile) {
      return static_cast<std::size_t>(tiling_.end(tile) - tiling_.begin(tile));
    };
    tasks_.push_back({t, u, 0, sites(t) * sites(u)});
  }

  Tiling tiling_;
  std::vector<Schedule::Task> tasks_;
};

}  // namespace ccvt
