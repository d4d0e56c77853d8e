#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "ccvt/domain.h"
#include "parallel/loops.h"
#include "relax/own_points.h"

namespace ccvt {

/// All points in an order in which what stands together lies together: along a Hilbert curve
/// through the bins of a grid in a box around them, and in a bin by their numbers. Of several
/// ranks, each knows the places of its own points. 8 bytes a point, as many more while it is made,
/// and O(points * dimensions).
class PointsAlongCurve {
 public:
  /// `box`: around the points of all ranks.
  template <class Scalar>
  PointsAlongCurve(const OwnPoints<Scalar>& points, std::int64_t points_of_all, const Box& box,
                   const Arena& arena);

  /// Of all ranks.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Of this rank, numbered from 0.
  [[nodiscard]] std::size_t own_count() const { return by_bin_.items.size(); }

  /// Calls visit(point, place, worker) for each point of this rank, `place` in 0..count() - 1.
  template <class Visit>
  void for_each(const Arena& arena, const Visit& visit) const {
    constexpr std::size_t kPointsPerGrain = 1 << 14;
    arena.for_ranges(own_count(), kPointsPerGrain,
                     [&](std::size_t begin, std::size_t end, int worker) {
                       for (std::size_t k = begin; k < end; ++k) {
                         const auto& [point, bin] = by_bin_.items[k];
                         visit(point, first_place(bin) + (k - by_bin_.first[bin]), worker);
                       }
                     });
  }

 private:
  struct Binned {
    PointNumber point;
    std::uint32_t bin;
  };
  void count_before(Ranks& ranks);
  [[nodiscard]] std::size_t first_place(std::size_t bin) const {
    return before_.empty() ? by_bin_.first[bin] : before_[bin];
  }

  std::size_t count_;
  Groups<Binned> by_bin_;
  std::vector<std::size_t> before_;  ///< places before those of this rank, by bin; of several ranks
};

}  // namespace ccvt
