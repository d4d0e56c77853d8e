#include "relax/levels.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "parallel/loops.h"
#include "relax/subsets.h"

namespace ccvt {
namespace {

constexpr std::uint64_t kLevelStream = 2;

std::int64_t total(std::span<const Index> capacities) {
  return std::accumulate(capacities.begin(), capacities.end(), std::int64_t{0});
}

/// Levels with their capacities, the coarsest first.
std::vector<Level> divide(std::span<const Index> capacities, const Options& options) {
  std::vector<Level> finest_first(1);
  finest_first[0].capacities.assign(capacities.begin(), capacities.end());
  const auto coarsest = std::int64_t{options.level_points} * std::ssize(capacities);
  while (options.multilevel &&
         total(finest_first.back().capacities) / options.level_factor >= coarsest) {
    Level coarse;
    coarse.capacities.reserve(capacities.size());
    for (const Index c : finest_first.back().capacities) {
      coarse.capacities.push_back((c - 1) / options.level_factor + 1);
    }
    finest_first.push_back(std::move(coarse));
  }
  std::reverse(finest_first.begin(), finest_first.end());
  return finest_first;
}

}  // namespace

/// The points of a level are the first of a random order.
std::vector<Level> make_levels(std::span<const Index> capacities, Index points,
                               const Options& options, const Arena& arena) {
  std::vector<Level> levels = divide(capacities, options);
  const auto count = static_cast<std::size_t>(points);
  std::vector<std::size_t> sizes;
  for (const Level& level : levels) {
    sizes.push_back(static_cast<std::size_t>(total(level.capacities)));
  }
  sizes.pop_back();  // all points
  const NestedSubsets subsets(options.seed, kLevelStream, count, sizes, arena);

  // Of the points of a block that join on a level, the first place: by level, and in it by block.
  constexpr std::size_t kBlock = NestedSubsets::kBlock;
  const std::size_t blocks = (count - 1) / kBlock + 1;
  std::vector<std::vector<std::size_t>> place(levels.size(), std::vector<std::size_t>(blocks));
  for (std::size_t b = 0; b < blocks; ++b) {
    std::size_t before = 0;
    for (std::size_t l = 0; l < levels.size(); ++l) {
      const std::size_t here =
          l < sizes.size() ? subsets.count(b, l) : std::min(kBlock, count - b * kBlock);
      place[l][b] = here - std::exchange(before, here);
    }
  }
  for (std::size_t l = 0; l < levels.size(); ++l) {
    levels[l].joining.reset(exclusive_scan(arena, std::span(place[l])));
  }
  arena.for_ranges(count, kBlock, [&](std::size_t begin, std::size_t end, int) {
    std::vector<PointNumber*> next;
    for (std::size_t l = 0; l < levels.size(); ++l) {
      next.push_back(levels[l].joining.data() + place[l][begin / kBlock]);
    }
    for (std::size_t p = begin; p < end; ++p) {
      *next[subsets.smallest_with(p)]++ = PointNumber(p);
    }
  });
  return levels;
}

}  // namespace ccvt
