#include "relax/levels.h"

#include <algorithm>
#include <memory>
#include <numeric>
#include <utility>

#include "parallel/loops.h"
#include "parallel/together.h"
#include "random.h"
#include "relax/subsets.h"
#include "streams.h"

namespace ccvt {
namespace {

std::int64_t total(std::span<const Index> capacities) {
  return std::accumulate(capacities.begin(), capacities.end(), std::int64_t{0});
}

/// How many points join on each level, of each block: a row a block.
std::vector<std::size_t> counts_by_block(const LevelOfPoints& own, std::size_t levels,
                                         std::size_t points, const Arena& arena) {
  constexpr std::size_t kBlock = JoiningPoints::kBlock;
  const std::size_t end = own.first + own.level.size();
  const std::size_t first_block = own.first / kBlock;
  const std::size_t end_block = own.level.empty() ? first_block : (end - 1) / kBlock + 1;
  std::vector<std::size_t> counts((end_block - first_block) * levels, 0);
  arena.for_each(end_block - first_block, 1, [&](std::size_t k) {
    const std::size_t begin = (first_block + k) * kBlock;
    const std::size_t last = std::min(begin + kBlock, end);
    for (std::size_t p = std::max(begin, own.first); p < last; ++p) ++counts[k * levels + own[p]];
  });
  if (arena.ranks() == nullptr) return counts;
  // Two ranks may have points of one block.
  const std::vector<std::size_t> firsts = of_all(arena.ranks(), first_block);
  const std::vector<std::size_t> sizes = of_all(arena.ranks(), counts.size());
  const std::vector<std::size_t> rows = joined(arena.ranks(), std::move(counts), sizes);
  std::vector<std::size_t> all(((points - 1) / kBlock + 1) * levels, 0);
  for (std::size_t r = 0, k = 0; r < sizes.size(); ++r) {
    for (std::size_t c = 0; c < sizes[r]; ++c) all[firsts[r] * levels + c] += rows[k++];
  }
  return all;
}

}  // namespace

std::vector<Level> make_levels(std::span<const Index> capacities, const Options& options) {
  std::vector<Level> levels(1);  // the finest first
  levels[0].capacities.assign(capacities.begin(), capacities.end());
  const auto coarsest = std::int64_t{options.level_points} * std::ssize(capacities);
  while (options.multilevel && total(levels.back().capacities) / options.level_factor >= coarsest) {
    Level coarse;
    coarse.capacities.reserve(capacities.size());
    for (const Index c : levels.back().capacities) {
      coarse.capacities.push_back((c - 1) / options.level_factor + 1);
    }
    levels.push_back(std::move(coarse));
  }
  std::reverse(levels.begin(), levels.end());
  if (levels.size() == 1) {
    const auto points = static_cast<std::size_t>(total(capacities));
    levels[0].joining = JoiningPoints::between(0, points);
  }
  return levels;
}

template <class Scalar>
void share_points(std::span<Level> levels, PointsAlongCurve<Scalar>& points, std::size_t first,
                  std::uint64_t seed, const Arena& arena) {
  std::vector<std::size_t> sizes;
  for (const Level& level : levels.first(levels.size() - 1)) {
    sizes.push_back(static_cast<std::size_t>(total(level.capacities)));
  }
  const NestedSubsets subsets(NestedSubsets::Order::even, Random(seed, streams::levels),
                              points.count(), sizes, arena);
  const auto own = std::make_shared<LevelOfPoints>();
  own->level.reset(points.own_count());
  own->first = first;
  points.for_each(arena, [&](PointNumber point, std::size_t place) {
    own->level[point] = static_cast<std::uint8_t>(subsets.smallest_with(place));
  });
  const std::vector<std::size_t> counts =
      counts_by_block(*own, levels.size(), points.count(), arena);
  std::vector<std::size_t> of_level(counts.size() / levels.size());
  for (std::size_t l = 0; l < levels.size(); ++l) {
    for (std::size_t b = 0; b < of_level.size(); ++b) of_level[b] = counts[b * levels.size() + l];
    levels[l].joining = JoiningPoints(own, l, of_level, points.count());
  }
}

template void share_points(std::span<Level>, PointsAlongCurve<float>&, std::size_t, std::uint64_t,
                           const Arena&);
template void share_points(std::span<Level>, PointsAlongCurve<double>&, std::size_t, std::uint64_t,
                           const Arena&);

JoiningPoints::JoiningPoints(std::shared_ptr<const LevelOfPoints> levels, std::size_t level,
                             std::span<const std::size_t> counts, std::size_t points)
    : levels_(std::move(levels)), level_(level), end_(points) {
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
    std::size_t begin = start_ + block * kBlock;
    const std::size_t end = std::min({begin + kBlock, end_, own_end});
    // Written in any case, so that there is nothing to predict; the last one not beyond its room.
    PointNumber* const stop = points.data() + (before_[block + 1] - before_[first]);
    if (levels_ != nullptr && begin < own_begin_) {
      begin = std::min(own_begin_, end);
      std::ptrdiff_t own = 0;
      for (std::size_t p = begin; p < end; ++p) own += joins(p) ? 1 : 0;
      while (block + 1 < last && stop - next > own) *next++ = PointNumber(-1);
    }
    for (std::size_t p = begin; p < end && next != stop; ++p) {
      *next = PointNumber(p - own_begin_);  // negative: of a lower rank
      next += joins(p) ? 1 : 0;
    }
    if (block + 1 == last) points_end = next;
  };
  arena.for_each(last - first, 1, [&](std::size_t k) {
    if (levels_ == nullptr) return fill(first + k, [](std::size_t) { return true; });
    fill(first + k, [this](std::size_t p) { return (*levels_)[p] == level_; });
  });
  if (whole) return points;
  const PointNumber* const begin =
      std::lower_bound(std::as_const(points).begin(), points_end, PointNumber(0));
  Buffer<PointNumber> own(static_cast<std::size_t>(points_end - begin));
  std::copy(begin, points_end, own.begin());
  return own;
}

}  // namespace ccvt
