#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {

/// A partition of a box into `count` cells of exactly equal volume, as cubic as possible, for any
/// count and any extents: slabs across the shortest dimension, cut into slabs across the next
/// shortest, and so on; the longest is cut last. A slab of c points cut into r gives floor or
/// ceil(c / r) of them to each and thickness in that proportion, so all slabs of one depth hold one
/// of two adjacent numbers of points. Of the possible r the one nearest to cubes is taken, or one
/// within a factor 1.25 of it that divides the count.
class Strata {
 public:
  /// Extents positive and finite; count >= 1. O(D log D + count^(1/2)).
  Strata(const Eigen::VectorXd& extent, std::int64_t count);

  [[nodiscard]] std::int64_t count() const { return count_; }

  /// Calls visit(index, lower, size) for cells first <= index < last, in order, with the corner and
  /// the sides of the cell (spans of D) for a box whose corner is `lower`. Cells have the same
  /// numbers whatever the range, so ranges may be visited apart. O(D) and O(1) a cell.
  template <class Visit>
  void visit(const Eigen::VectorXd& lower, std::int64_t first, std::int64_t last,
             const Visit& visit) const {
    Eigen::VectorXd corner = lower;
    Eigen::VectorXd size = extent_;
    descend(Walk<Visit>{lower, corner, size, first, last, visit}, 0, 0, count_);
  }

 private:
  struct Cut {
    Eigen::Index dimension;
    std::int64_t parts;  // not used for the last cut, which makes single cells
  };

  template <class Visit>
  struct Walk {
    const Eigen::VectorXd& lower;
    Eigen::VectorXd& corner;
    Eigen::VectorXd& size;
    std::int64_t first;
    std::int64_t last;
    const Visit& visit;
  };

  // Visits the slab of `count` cells that starts with cell `base`, cut along cuts_[depth].
  template <class Visit>
  void descend(const Walk<Visit>& walk, std::size_t depth, std::int64_t base,
               std::int64_t count) const {
    const Eigen::Index d = cuts_[depth].dimension;
    const double lower = walk.lower[d];
    const double unit = extent_[d] / static_cast<double>(count);
    const std::int64_t skip = std::max(walk.first - base, std::int64_t{0});
    if (depth + 1 == cuts_.size()) {
      const std::int64_t end = std::min(count, walk.last - base);
      const Eigen::Index dimensions = extent_.size();
      const std::span<const double> corner(walk.corner.data(), walk.corner.data() + dimensions);
      const std::span<const double> size(walk.size.data(), walk.size.data() + dimensions);
      walk.size[d] = unit;
      for (std::int64_t k = skip; k < end; ++k) {
        walk.corner[d] = lower + static_cast<double>(k) * unit;
        walk.visit(base + k, corner, size);
      }
      return;
    }
    // Slab s holds cells floor(s * count / parts) up to floor((s + 1) * count / parts).
    const std::int64_t parts = std::min(cuts_[depth].parts, count);
    const auto begin_of = [&](std::int64_t s) { return s * count / parts; };
    std::int64_t s = skip;
    s = ((s + 1) * parts - 1) / count;
    for (std::int64_t begin = begin_of(s); begin < count && base + begin < walk.last; ++s) {
      const std::int64_t end = begin_of(s + 1);
      walk.corner[d] = lower + static_cast<double>(begin) * unit;
      walk.size[d] = static_cast<double>(end - begin) * unit;
      descend(walk, depth + 1, base + begin, end - begin);
      begin = end;
    }
  }

  Eigen::VectorXd extent_;
  std::int64_t count_;
  std::vector<Cut> cuts_;
};

}  // namespace ccvt
