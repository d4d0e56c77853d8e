#include "relax/levels.h"

#include <algorithm>
#include <numeric>

#include "random.h"

namespace ccvt {
namespace {

constexpr std::uint64_t kLevelStream = 2;
constexpr Index kBetweenChecks = 1 << 14;

std::int64_t total(std::span<const Index> capacities) {
  return std::accumulate(capacities.begin(), capacities.end(), std::int64_t{0});
}

}  // namespace

std::vector<Level> make_levels(std::span<const Index> capacities, Index points,
                               const Options& options, const Arena& arena) {
  std::vector<Level> levels(1);
  levels[0].capacities.assign(capacities.begin(), capacities.end());
  if (options.multilevel) {
    const auto coarsest = static_cast<std::int64_t>(options.level_points) *
                          static_cast<std::int64_t>(capacities.size());
    while (total(levels[0].capacities) / options.level_factor >= coarsest) {
      Level coarse;
      for (const Index c : levels[0].capacities) {
        coarse.capacities.push_back((c - 1) / options.level_factor + 1);
      }
      levels.insert(levels.begin(), std::move(coarse));
    }
  }
  if (levels.size() == 1) {
    levels[0].joining.resize(static_cast<std::size_t>(points));
    std::iota(levels[0].joining.begin(), levels[0].joining.end(), 0);
    return levels;
  }

  // Selection sampling [Knuth, TAOCP 2, 3.4.2, algorithm S], for all levels in one sweep: a point
  // that is on level l + 1 is on level l with probability needed[l] / needed[l + 1], where needed
  // counts the places still free on each.
  Random random(options.seed, kLevelStream);
  std::vector<std::int64_t> needed;
  for (const Level& level : levels) needed.push_back(total(level.capacities));
  for (std::size_t l = 0; l < levels.size(); ++l) {
    levels[l].joining.reserve(
        static_cast<std::size_t>(needed[l] - (l > 0 ? needed[l - 1] : std::int64_t{0})));
  }
  for (Index p = 0; p < points; ++p) {
    if (p % kBetweenChecks == 0) arena.check();
    std::size_t joins = levels.size() - 1;
    while (joins > 0) {
      const auto draw = random.below(static_cast<std::uint64_t>(needed[joins]));
      if (draw >= static_cast<std::uint64_t>(needed[joins - 1])) break;
      --joins;
    }
    for (std::size_t l = joins; l < levels.size(); ++l) --needed[l];
    levels[joins].joining.push_back(p);
  }
  return levels;
}

}  // namespace ccvt
