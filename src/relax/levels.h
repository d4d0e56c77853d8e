#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "ccvt/options.h"
#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/buffer.h"
#include "relax/along_curve.h"

namespace ccvt {

/// The level on which each point of a rank joins, from the first of them on.
struct LevelOfPoints {
  Buffer<std::uint8_t> level;
  std::size_t first = 0;

  [[nodiscard]] std::uint8_t operator[](std::size_t point) const { return level[point - first]; }
};

/// The points that join on a level. They are not kept but found again when they are asked for: a
/// list of all would be the half of a point set in two dimensions.
class JoiningPoints {
 public:
  /// Points that are looked at, and counted, together.
  static constexpr std::size_t kBlock = 1 << 16;

  JoiningPoints() = default;
  /// Those of points 0.. on a level: `counts` of each block of points.
  JoiningPoints(std::shared_ptr<const LevelOfPoints> levels, std::size_t level,
                std::span<const std::size_t> counts, std::size_t points);
  /// Points start.. to end - 1.
  static JoiningPoints between(std::size_t start, std::size_t end);

  /// From now on only those of a rank are given out, numbered from its first.
  void keep_own(std::size_t begin, std::size_t end) {
    own_begin_ = begin;
    own_end_ = end;
  }

  /// Of all ranks.
  [[nodiscard]] std::size_t size() const { return before_.back(); }
  /// Ascending. O(points).
  [[nodiscard]] Buffer<PointNumber> all(const Arena& arena = Arena(1)) const {
    return in_blocks(0, before_.size() - 1, arena);
  }
  /// Calls visit(points) for one part of them after the other, each of `most` at the most, or of
  /// one block.
  template <class Visit>
  void for_parts(std::size_t most, const Arena& arena, const Visit& visit) const {
    for_blocks(most, [&](std::size_t first, std::size_t last) {
      const Buffer<PointNumber> points = in_blocks(first, last, arena);
      visit(points.span());
    });
  }
  /// The first point that may be in each of these parts, of all ranks.
  [[nodiscard]] std::vector<PointOfAll> parts(std::size_t most) const {
    std::vector<PointOfAll> begins;
    for_blocks(most, [&](std::size_t first, std::size_t) {
      begins.emplace_back(start_ + first * kBlock);
    });
    return begins;
  }
  /// The first point that may be this rank's, and one more than the last of all ranks.
  [[nodiscard]] PointOfAll own_begin() const { return PointOfAll(std::min(own_begin_, end_)); }
  [[nodiscard]] PointOfAll end() const { return PointOfAll(end_); }
  /// Only those of this rank, in parts of their own, each of them in one of those that parts() of
  /// `most_of_all` begins.
  template <class Visit>
  void for_own_parts(std::size_t most, std::size_t most_of_all, const Arena& arena,
                     const Visit& visit) const {
    const std::size_t begin = std::max(own_begin_, start_) - start_;
    const std::size_t end = std::max(std::min(own_end_, end_) - start_, begin);
    std::size_t first = begin / kBlock;
    const std::size_t blocks = (end + kBlock - 1) / kBlock;
    for_blocks(most_of_all, [&](std::size_t, std::size_t part_end) {
      const std::size_t stop = std::min(part_end, blocks);
      for (std::size_t last = first; first < stop; first = last) {
        while (last < stop && (last == first || before_[last + 1] - before_[first] <= most)) ++last;
        const Buffer<PointNumber> points = in_blocks(first, last, arena);
        visit(points.span());
      }
    });
  }

 private:
  template <class Visit>
  void for_blocks(std::size_t most, const Visit& visit) const {
    const std::size_t blocks = before_.size() - 1;
    for (std::size_t first = 0, last = 0; first < blocks; first = last) {
      while (last < blocks && (last == first || before_[last + 1] - before_[first] <= most)) ++last;
      visit(first, last);
    }
  }
  [[nodiscard]] Buffer<PointNumber> in_blocks(std::size_t first, std::size_t last,
                                              const Arena& arena) const;

  std::shared_ptr<const LevelOfPoints> levels_;  ///< or none: all points join
  std::size_t level_ = 0;
  std::size_t start_ = 0;
  std::size_t end_ = 0;
  std::size_t own_begin_ = 0;
  std::size_t own_end_ = SIZE_MAX;
  std::vector<std::size_t> before_{0};  ///< how many are in the blocks before each; and in all
};

/// One level of the multi-level optimisation [5.2].
struct Level {
  std::vector<Index> capacities;  ///< of the sites on this level
  JoiningPoints joining;
};

/// The levels of a run, the coarsest first. Of the last one capacities are those given; one level
/// without Options::multilevel, or when capacities are too small to divide. Where there is one, all
/// points join.
std::vector<Level> make_levels(std::span<const Index> capacities, const Options& options);

/// Splits the points into nested random subsets: level l holds the points that join on levels
/// 0..l, as many as its capacities sum to, evenly along the curve: see NestedSubsets. On the last
/// level all have joined. `first`: of this rank's points. O(m).
template <class Scalar>
void share_points(std::span<Level> levels, PointsAlongCurve<Scalar>& points, std::size_t first,
                  std::uint64_t seed, const Arena& arena);

}  // namespace ccvt
