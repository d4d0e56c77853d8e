#pragma once

#include <span>
#include <utility>
#include <vector>

#include "descent/site_views.h"
#include "geometry/metric.h"
#include "parallel/loops.h"
#include "relax/cells.h"
#include "relax/filling.h"

namespace ccvt {

/// The points near the borders of cells. Only they can change owners while the sites move a little,
/// and what a power diagram of the sites owns is counted from them alone; the others stay with
/// their owners.
///
/// A point is near a border when its power distance to another site is less than a threshold above
/// that to its own.
template <class Scalar>
class Borders {
 public:
  /// Where several ranks have the tiles, each has the points in cells of its own, and what is
  /// counted of sites is on all.
  Borders(const Metric& metric, const Arena& arena, Tiling tiling)
      : arena_(arena),
        tiling_(std::move(tiling)),
        dimension_(metric.coordinate_count()),
        views_(metric, arena),
        scratch_(arena) {}

  /// Finds the points near borders, O(points * neighbours). `position` and `radius` are the sites'
  /// own, and bound the cells; `near` holds all pairs of sites whose cells can meet, each once;
  /// `share` is the threshold, of the squared radius of each cell.
  void find(const Cells<Scalar>& cells, std::span<const double> position,
            std::span<const double> radius, std::span<const double> weight,
            std::span<const Pair> near, double share);

  /// Counts what each site of the diagram owns, O(points near borders * neighbours).
  void count(const PowerDiagram& diagram);

  /// Of the last diagram counted: the points of each site less its capacity.
  [[nodiscard]] std::span<const double> surplus() const { return surplus_; }
  /// Of each site, the vector to the centroid of what it owns.
  [[nodiscard]] const std::vector<double>& to_centroid() const { return to_centroid_; }
  /// The energy of the sites with full cells, from below: the dual of the problem of transport
  /// [Kantorovich 1942], which the surpluses enter in second order.
  [[nodiscard]] double energy() const { return energy_; }
  /// By how much each weight must grow so that, to first order, no surplus is left: a step of
  /// Newton's method on the dual.
  [[nodiscard]] std::vector<double> correction() const;
  /// The same for the surpluses that come, to first order, when the sites take these steps and each
  /// weight grows by the square of its own.
  [[nodiscard]] std::vector<double> correction(std::span<const double> step) const;
  /// How far the diagram has used up the thresholds, in the mean over the cells: beyond 1 many
  /// points that would have changed owners were not asked.
  [[nodiscard]] double used() const { return used_; }
  [[nodiscard]] std::size_t size() const { return place_.size(); }

  /// Points change to the owners last counted. Cells may then be too full, or not full. How many,
  /// on all ranks.
  std::int64_t change_owners(Filling<Scalar>& filling) const;

 private:
  using View = typename SiteViews<Scalar>::View;
  /// Consecutive points of a cell, or of those near its borders.
  struct Block {
    SiteNumber cell;
    std::size_t begin;
    std::size_t end;
    [[nodiscard]] std::size_t size() const { return end - begin; }
  };
  struct Scratch {
    std::vector<Scalar> points;
    std::vector<Index> places;
    std::vector<Index> nearest;
    std::vector<Index> next;
    std::vector<Scalar> margin;
    void make_room(std::size_t count, std::size_t dimension);
  };

  /// A sum over points: how many, and their coordinates relative to the cell's reference.
  [[nodiscard]] std::size_t sum_size() const { return 1 + dimension_; }
  /// What a block has for a site: the sum of the points that it owns, in the end relative to the
  /// site; and that of those at the border between it and the cell's own.
  [[nodiscard]] std::size_t part_size() const { return 2 * sum_size(); }

  void split(const Cells<Scalar>& cells);
  double sum_block(const Block& block, const Cells<Scalar>& cells, Scratch& own, double* inner,
                   std::vector<Index>& near) const;
  void keep(const Cells<Scalar>& cells);
  double count_block(std::size_t number, Scratch& own);
  /// Calls move(place, to) for each point of a cell that changes its owner, from the last to the
  /// first, so that filling a gap does not move another.
  template <class Move>
  void for_each_leaving(SiteNumber cell, const Move& move) const {
    for (std::size_t k = first_[cell + 1]; k-- > first_[cell];) {
      if (owner_[k] == 0) continue;
      const View view(views_.own(cell) + static_cast<std::size_t>(owner_[k]));
      move(place_[k], views_.site(view));
    }
  }

  // Of several ranks, in borders_ranks.cpp.
  void exchange_parts();
  void share_counts(std::vector<double>& energy);
  void share_leaving(std::vector<double>& leaving) const;
  std::int64_t change_owners_on_ranks(Filling<Scalar>& filling) const;

  template <std::size_t Dimension>
  std::int64_t change_owners_in(Filling<Scalar>& filling) const;

  double gather(SiteNumber site, const PowerDiagram& diagram);
  [[nodiscard]] std::vector<double> leaving(std::span<const double> step) const;
  [[nodiscard]] double mass(View view) const { return mass_[view]; }
  [[nodiscard]] std::vector<double> weights_for(std::span<const double> lack) const;
  [[nodiscard]] std::size_t stride(SiteNumber cell) const {
    return first_[cell + 1] - first_[cell];
  }

  const Arena& arena_;
  Tiling tiling_;  ///< its own: that of a run that is loaded does not last
  std::size_t dimension_;
  SiteViews<Scalar> views_;
  PerWorker<Scratch> scratch_;

  // Cells.
  std::vector<double> capacity_;
  std::vector<double> threshold_;
  std::vector<double> width_;  ///< of the border, where points are counted for its mass
  std::vector<double> inner_;  ///< the sum of the points that are not near a border
  double squares_ = 0;         ///< of all points, from their references

  // Points near borders, in blocks, of cells that are here.
  std::vector<std::size_t> first_;  ///< of each cell, and one more
  Buffer<Index> place_;             ///< in their cell, ascending
  Buffer<Scalar> points_;           ///< of each cell a stream for each dimension
  Buffer<Index> owner_;             ///< which of the cell's views
  std::vector<Block> blocks_;
  std::vector<std::size_t> first_block_;  ///< of each cell, and one more
  std::vector<std::size_t> first_part_;   ///< of each block, and one more
  Buffer<double> totals_;                 ///< the sum of each block's coordinates
  Buffer<double> parts_;                  ///< of each block, one for each view

  /// What blocks of cells of other ranks have for sites of this one: of each view of such a cell,
  /// where their sums begin, and how many there are.
  struct OfOthers {
    std::size_t begin = 0;
    std::size_t blocks = 0;
  };
  std::vector<OfOthers> of_others_;
  std::vector<double> sums_of_others_;

  // Of the last diagram.
  std::vector<double> surplus_;
  std::vector<double> to_centroid_;
  /// Of each view from a cell that is here: the sum of the points at the border with the cell's own
  /// site; and of each view, how many these are.
  std::vector<double> at_border_;
  std::vector<double> mass_;
  double energy_ = 0;
  double used_ = 0;
};

extern template class Borders<float>;
extern template class Borders<double>;

}  // namespace ccvt
