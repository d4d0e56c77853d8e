#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "ccvt/domain.h"
#include "parallel/loops.h"
#include "relax/own_points.h"
#include "sampling/curve_grid.h"

namespace ccvt {

/// All points in an order in which what stands together lies together: along a Hilbert curve
/// through the bins of a grid in a box around them, and in a bin by their numbers. Of several
/// ranks, each knows the places of its own points. O(points * dimensions). Nothing is sorted: in
/// each of some runs of points, one for each worker, it is counted how many are in each bin. 4
/// bytes a bin and run: 16 a point of this rank at most, or those of one run, up to 2 MB.
template <class Scalar>
class PointsAlongCurve {
 public:
  /// `box`: around the points of all ranks.
  PointsAlongCurve(const OwnPoints<Scalar>& points, std::int64_t points_of_all, const Box& box,
                   const Arena& arena);

  /// Of all ranks.
  [[nodiscard]] std::size_t count() const { return count_; }
  /// Of this rank, numbered from 0.
  [[nodiscard]] std::size_t own_count() const {
    return static_cast<std::size_t>(points_.view().count);
  }

  /// Calls visit(point, place) for each point of this rank, `place` in 0..count() - 1. Once: the
  /// places of a bin are given away one after the other.
  template <class Visit>
  void for_each(const Arena& arena, const Visit& visit) {
    arena.for_each(runs_, 1, [&](std::size_t run) {
      visit_cells(arena, run, [&](PointNumber p, std::size_t cell, std::uint32_t& next) {
        visit(p, std::size_t{next++} + (before_cell_.empty() ? 0 : before_cell_[cell]));
      });
    });
  }

 private:
  void count_before(Ranks& ranks, const std::vector<std::uint32_t>& sizes);
  [[nodiscard]] std::uint32_t* of_cells(std::size_t run) {
    return of_cells_.data() + run * grid_.count();
  }

  /// Calls visit(point, cell, value) for each point of a run in the order of their numbers, with
  /// the value that the run has for its cell. A few are fetched ahead: the cache does not hold all.
  template <class Visit>
  void visit_cells(const Arena& arena, std::size_t run, const Visit& visit) {
    constexpr std::size_t kAhead = 16;
    constexpr std::size_t kBetweenChecks = 1 << 10;  // of so many
    std::size_t until_check = 0;
    std::array<std::size_t, kAhead> cells;
    std::uint32_t* const values = of_cells(run);
    const std::size_t end = own_count() * (run + 1) / runs_;
    for (std::size_t begin = own_count() * run / runs_; begin < end; begin += kAhead) {
      if (until_check-- == 0) {
        until_check = kBetweenChecks;
        arena.check();
      }
      const std::size_t count = std::min(kAhead, end - begin);
      for (std::size_t k = 0; k < count; ++k) {
        cells.data()[k] = grid_.cell_of(points_[PointNumber(begin + k)]);
        __builtin_prefetch(values + cells.data()[k], 1);
      }
      for (std::size_t k = 0; k < count; ++k) {
        visit(PointNumber(begin + k), cells.data()[k], values[cells.data()[k]]);
      }
    }
  }

  OwnPoints<Scalar> points_;
  std::size_t count_;
  CurveGrid grid_;
  std::size_t runs_;
  /// Of each run, by cell of the grid: how many points, then the place of the next.
  Buffer<std::uint32_t> of_cells_;
  /// Of several ranks, places of lower bins and ranks; those of `of_cells_` are in the bin then.
  std::vector<std::size_t> before_cell_;
};

extern template class PointsAlongCurve<float>;
extern template class PointsAlongCurve<double>;

}  // namespace ccvt
