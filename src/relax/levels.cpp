#include "relax/levels.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "parallel/loops.h"
#include "streams.h"

namespace ccvt {
namespace {

constexpr std::size_t kBlock = NestedSubsets::kBlock;

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
std::vector<Level> make_levels(std::span<const Index> capacities, std::int64_t points,
                               const Options& options, const Arena& arena) {
  std::vector<Level> levels = divide(capacities, options);
  const auto count = static_cast<std::size_t>(points);
  std::vector<std::size_t> sizes;
  for (const Level& level : levels) {
    sizes.push_back(static_cast<std::size_t>(total(level.capacities)));
  }
  sizes.pop_back();  // all points
  const auto subsets =
      std::make_shared<NestedSubsets>(options.seed, streams::levels, count, sizes, arena);

  std::vector<std::size_t> counts((count - 1) / kBlock + 1);  // of points that join, in each block
  for (std::size_t l = 0; l < levels.size(); ++l) {
    for (std::size_t b = 0; b < counts.size(); ++b) {
      const std::size_t here =
          l < sizes.size() ? subsets->count(b, l) : std::min(kBlock, count - b * kBlock);
      counts[b] = l > 0 ? here - subsets->count(b, l - 1) : here;
    }
    levels[l].joining = JoiningPoints(subsets, l, counts, count);
  }
  return levels;
}

JoiningPoints::JoiningPoints(std::shared_ptr<const NestedSubsets> subsets, std::size_t subset,
                             std::span<const std::size_t> counts, std::size_t points)
    : subsets_(std::move(subsets)), subset_(subset), end_(points) {
  for (const std::size_t count : counts) before_.push_back(before_.back() + count);
}

JoiningPoints JoiningPoints::between(std::size_t start, std::size_t end) {
  JoiningPoints joining;
  joining.start_ = start;
  joining.end_ = end;
  for (std::size_t block = start; block < end; block += kBlock) {
    joining.before_.push_back(std::min(block + kBlock, end) - start);
  }
  return joining;
}

/// Points of blocks that are another rank's in part are found, too, and left out.
Buffer<PointNumber> JoiningPoints::in_blocks(std::size_t first, std::size_t last,
                                             const Arena& arena) const {
  const auto charge = arena.phase(Phase::levels);
  const std::size_t own_end = std::max(own_begin_, own_end_);
  const std::size_t end_of_last = std::min(start_ + last * kBlock, end_);
  const bool whole = start_ + first * kBlock >= own_begin_ && end_of_last <= own_end;
  if (!whole) {
    const auto own = [&](std::size_t point) {
      return std::clamp(point, own_begin_, own_end) - start_;
    };
    first = std::clamp(own(start_ + first * kBlock) / kBlock, first, last);
    last = std::clamp((own(end_of_last) + kBlock - 1) / kBlock, first, last);
  }
  Buffer<PointNumber> points(before_[last] - before_[first]);
  const PointNumber* points_end = points.begin();
  const auto fill = [&](std::size_t block, const auto& joins) {
    PointNumber* next = points.data() + (before_[block] - before_[first]);
    const std::size_t begin = start_ + block * kBlock;
    const std::size_t end = std::min({begin + kBlock, end_, own_end});
    // Written in any case, so that there is nothing to predict; the last one not beyond its room.
    PointNumber* const stop = points.data() + (before_[block + 1] - before_[first]);
    for (std::size_t p = begin; p < end && next != stop; ++p) {
      *next = PointNumber(p - own_begin_);  // negative: of a lower rank
      next += joins(p) ? 1 : 0;
    }
    if (block + 1 == last) points_end = next;
  };
  arena.for_each(last - first, 1, [&](std::size_t k) {
    if (subsets_ == nullptr) return fill(first + k, [](std::size_t) { return true; });
    fill(first + k,
         [members = subsets_->members(subset_)](std::size_t p) { return members.contains(p); });
  });
  if (whole) return points;
  const PointNumber* const begin =
      std::lower_bound(std::as_const(points).begin(), points_end, PointNumber(0));
  Buffer<PointNumber> own(static_cast<std::size_t>(points_end - begin));
  std::copy(begin, points_end, own.begin());
  return own;
}

}  // namespace ccvt
