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
/// ranks, each knows the places of its own points. O(points * dimensions). One worker needs 4 bytes
/// a bin, of which there are at most half a million; several, 8 bytes a point, and as many more
/// while it is made.
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

  /// Calls visit(point, place, worker) for each point of this rank, `place` in 0..count() - 1.
  template <class Visit>
  void for_each(const Arena& arena, const Visit& visit) const {
    if (!first_in_cell_.empty()) return visit_one_by_one(visit);
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
  void count_in_cells();
  void group(const Arena& arena);
  void count_before(Ranks& ranks, const std::vector<std::uint32_t>& sizes);
  [[nodiscard]] std::size_t first_place(std::size_t bin) const {
    return before_.empty() ? by_bin_.first[bin] : before_[bin];
  }
  [[nodiscard]] std::size_t cell_of(PointNumber point) const {
    return grid_.cell_of(points_[point]);
  }

  /// Calls visit(point, of_cells[cell]) for each point of this rank in the order of their numbers,
  /// with the value of its cell. Some values are fetched ahead: all do not fit into the cache.
  template <class Value, class Visit>
  void visit_cells(std::vector<Value>& of_cells, const Visit& visit) const {
    constexpr std::size_t kAhead = 16;
    std::array<Value*, kAhead> values;
    for (std::size_t begin = 0; begin < own_count(); begin += kAhead) {
      const std::size_t count = std::min(kAhead, own_count() - begin);
      for (std::size_t k = 0; k < count; ++k) {
        values.data()[k] = of_cells.data() + cell_of(PointNumber(begin + k));
        __builtin_prefetch(values.data()[k], 1);
      }
      for (std::size_t k = 0; k < count; ++k) visit(PointNumber(begin + k), *values.data()[k]);
    }
  }
  /// In the order of their numbers, each comes to the next place of its bin.
  template <class Visit>
  void visit_one_by_one(const Visit& visit) const {
    const auto visit_all = [&](auto next) {
      visit_cells(next, [&](PointNumber p, auto& place) { visit(p, std::size_t{place++}, 0); });
    };
    if (before_.empty()) return visit_all(first_in_cell_);
    std::vector<std::size_t> next(grid_.count());
    std::size_t bin = 0;
    grid_.visit_along_curve([&](std::size_t cell) { next[cell] = before_[bin++]; });
    visit_all(std::move(next));
  }

  OwnPoints<Scalar> points_;
  std::size_t count_;
  CurveGrid grid_;
  /// Of one worker: this rank's places before those in each cell of the grid.
  std::vector<std::uint32_t> first_in_cell_;
  /// Of several workers.
  Groups<Binned> by_bin_;
  /// Of several ranks: all places before those of this one in each bin, along the curve.
  std::vector<std::size_t> before_;
};

extern template class PointsAlongCurve<float>;
extern template class PointsAlongCurve<double>;

}  // namespace ccvt
