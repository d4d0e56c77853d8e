#pragma once

#include <span>
#include <vector>

#include "geometry/metric.h"
#include "kernels/power.h"
#include "parallel/loops.h"
#include "relax/cells.h"
#include "relax/filling.h"
#include "schedule/pair.h"

namespace ccvt {

/// Positions of sites, as steps from where they were when the borders were found, and their
/// weights: a point p belongs to the site s with the least |p - s|^2 - weight.
struct PowerDiagram {
  std::vector<double> step;  ///< dimension values for each site
  std::vector<double> weight;
};

/// The points near the borders of cells: only they can change owners while the sites move a little,
/// and what a power diagram of the sites owns is counted from them alone.
///
/// A point is near a border when its power distance to another site is less than a threshold above
/// that to its own. Coordinates are kept relative to the cell's site, so that a torus needs no
/// further thought.
template <class Scalar>
class Borders {
 public:
  Borders(const Metric& metric, const Arena& arena)
      : metric_(metric),
        arena_(arena),
        dimension_(metric.coordinate_count()),
        scratch_(arena) {}

  /// Finds the points near borders, O(points * neighbours). `position` and `radius` are the sites'
  /// own, and bound the cells; `near` holds all pairs of sites whose cells can meet, each once;
  /// `share` is the threshold, of the squared radius of each cell.
  void find(const Cells<Scalar>& cells, std::span<const double> position,
            std::span<const double> radius, std::span<const double> weight,
            std::span<const Pair> near, double share);

  /// Counts what each site of the diagram owns, O(points near borders * neighbours). False, and
  /// nothing is counted, when points that are not near a border might have changed owners.
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
  /// How much of the threshold the diagram has used up, at most.
  [[nodiscard]] double used() const { return used_; }
  [[nodiscard]] std::size_t size() const { return place_.size(); }

  /// Points change to the owners last counted; cells may then be too full, or not full. How many.
  Index change_owners(Filling<Scalar>& filling) const;

 private:
  using Slot = Number<struct OfSlots>;  ///< of a site as seen from a cell, its own the first
  /// Consecutive points of a cell, or of those near its borders.
  struct Block {
    SiteNumber cell;
    std::size_t begin;
    std::size_t end;
  };
  struct Scratch {
    std::vector<Scalar> points;
    std::vector<Index> places;
    std::vector<Index> nearest;
    std::vector<Index> next;
    std::vector<Scalar> margin;
    std::vector<double> part;
  };

  void link(const Cells<Scalar>& cells, std::span<const Pair> near);
  void set_thresholds(std::span<const double> position, std::span<const double> radius,
                      std::span<const double> weight, double share);
  void split(const Cells<Scalar>& cells);
  void keep(const Cells<Scalar>& cells);
  double see(SiteNumber cell, const PowerDiagram& diagram);
  double count_block(std::size_t number, Scratch& own, double* part);
  void gather(const PowerDiagram& diagram);
  Scalar relative(SiteNumber cell, Scalar x, std::size_t d) const;

  [[nodiscard]] NumberRange<Slot> slots(SiteNumber cell) const {
    return {Slot(first_slot_[cell]), Slot(first_slot_[cell + 1])};
  }
  [[nodiscard]] std::size_t slot_count(SiteNumber cell) const {
    return first_slot_[cell + 1] - first_slot_[cell];
  }
  /// Values of a part: points, their coordinates relative to the site, points at its border.
  [[nodiscard]] std::size_t part_size() const { return dimension_ + 2; }
  [[nodiscard]] double power_gap(SiteNumber cell, Slot slot) const;
  [[nodiscard]] kernels::PowerSites<Scalar> seen_from(SiteNumber cell) const {
    const std::size_t first = first_slot_[cell];
    return {&slope_[first * dimension_], &offset_[first], static_cast<Index>(slot_count(cell))};
  }
  [[nodiscard]] kernels::NearestPowers<Scalar> nearest(SiteNumber cell, const Scalar* points,
                                                       std::size_t stride, std::size_t count,
                                                       Scratch& own) const;

  const Metric& metric_;
  const Arena& arena_;
  std::size_t dimension_;
  PerWorker<Scratch> scratch_;

  // Sites as seen from cells.
  std::vector<std::size_t> first_slot_;
  std::vector<SiteNumber> site_;       ///< of each slot
  std::vector<Slot> twin_;             ///< the cell's own site, as seen from the slot's
  std::vector<double> from_reference_; ///< where the site was, relative to the cell's reference
  std::vector<double> now_;            ///< where it is in the diagram
  std::vector<double> gap_;            ///< power of the site's position less that of the own
  std::vector<double> room_;           ///< for a change of power differences
  std::vector<Scalar> slope_;          ///< of the diagram, as the kernel wants them
  std::vector<Scalar> offset_;
  std::vector<double> mass_;           ///< points at the border between the two sites

  // Cells.
  std::vector<double> capacity_;
  std::vector<Scalar> reference_;      ///< a position near the site
  std::vector<double> reach_;          ///< of the cell's points, from the reference
  std::vector<double> threshold_;
  std::vector<double> width_;          ///< of the border, where points are counted for its mass
  std::vector<double> inner_;          ///< parts: of points that are not near a border
  double squares_ = 0;                 ///< of all points, from their references

  // Points near borders.
  std::vector<std::size_t> first_;     ///< of each cell
  Buffer<Index> place_;                ///< in their cell, ascending
  Buffer<Scalar> points_;              ///< of each cell a stream for each dimension
  Buffer<Index> owner_;                ///< as a slot of the cell
  std::vector<Block> blocks_;
  std::vector<double> totals_;            ///< of the points of each block, the sum
  std::vector<std::size_t> first_block_;  ///< of each cell
  std::vector<std::size_t> first_part_;   ///< of each block
  std::vector<double> parts_;             ///< of each block, one for each slot
  Groups<Slot> seen_;                     ///< the slots of each site, by the cells that see it

  std::vector<double> surplus_;
  std::vector<double> to_centroid_;
  double energy_ = 0;
  double used_ = 0;
};

extern template class Borders<float>;
extern template class Borders<double>;

}  // namespace ccvt
