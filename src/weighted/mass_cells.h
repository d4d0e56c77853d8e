#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "relax/site_state.h"

namespace ccvt {

/// The cells of points with masses: any number of points each. All masses are in the same units,
/// of about the mean mass of a point.
template <class Scalar>
class MassCells {
 public:
  /// Keeps references. Points of mass 0 belong to no cell. `sites`: where they are; they move to
  /// the centres of mass of the cells that `owners` makes. `coordinate_bound`: on the absolute
  /// values of all coordinates.
  MassCells(const Metric& metric, PointsView<Scalar> points, std::span<const double> masses,
            std::span<const double> capacities, std::span<const Index> owners, SiteState sites,
            double coordinate_bound, const Arena& arena);

  [[nodiscard]] const Metric& metric() const { return metric_; }
  [[nodiscard]] const SiteState& sites() const { return sites_; }
  [[nodiscard]] std::size_t site_count() const { return cells_.size(); }
  [[nodiscard]] const Scalar* at(PointNumber point) const { return points_[point.index()]; }
  [[nodiscard]] double mass(PointNumber point) const { return masses_[point]; }
  [[nodiscard]] double heaviest() const { return heaviest_; }
  /// What errors stay below: the mass of the heaviest point, less what rounding could hide.
  [[nodiscard]] double error_bound() const { return heaviest_ * (1 - 1e-9); }

  /// The points of a cell, by mass, those of equal mass by number; and their masses.
  [[nodiscard]] std::span<const PointNumber> members(SiteNumber site) const {
    return cells_[site].points;
  }
  [[nodiscard]] std::span<const double> masses(SiteNumber site) const {
    return cells_[site].masses;
  }
  /// Their coordinates: one stream for each dimension.
  [[nodiscard]] const Scalar* block(SiteNumber site) const {
    return cells_[site].coordinates.data();
  }
  [[nodiscard]] double capacity(SiteNumber site) const { return capacities_[site]; }
  /// The mass of a cell, and what it is too heavy by.
  [[nodiscard]] double held(SiteNumber site) const { return held_[site]; }
  [[nodiscard]] double error(SiteNumber site) const { return held_[site] - capacities_[site]; }
  /// What rounding the site to where it is may have added to the energy of its cell, at most.
  [[nodiscard]] double margin(SiteNumber site) const { return margin_[site]; }

  /// Gives a cell other points, in any order. The site stays where it is: see update().
  void set_members(SiteNumber site, std::vector<PointNumber> members);
  void move(PointNumber point, SiteNumber from, SiteNumber to);
  /// Gives both of two cells new members, by mass as in members(): numbers below as many as i has
  /// are places in cell i, those from there on in cell j.
  void regroup(SiteNumber i, SiteNumber j, std::span<const std::size_t> to_first,
               std::span<const std::size_t> to_second);
  /// Moves a site to the centre of mass of its cell, and renews its energy and radius. On a torus
  /// the centre is that of the images nearest to it, as in update_site(). An empty cell's stays.
  void update(SiteNumber site);

  /// The owner of each point; -1 of those without mass.
  [[nodiscard]] std::vector<Index> owners() const;

 private:
  struct Cell {
    std::vector<PointNumber> points;
    std::vector<double> masses;
    std::vector<Scalar> coordinates;
  };
  /// The order of members.
  [[nodiscard]] bool precedes(PointNumber a, PointNumber b) const {
    return masses_[a] != masses_[b] ? masses_[a] < masses_[b] : a < b;
  }
  [[nodiscard]] std::size_t place_in(const Cell& cell, PointNumber point) const;
  void insert(Cell& cell, PointNumber point) const;
  void remove(Cell& cell, PointNumber point) const;
  [[nodiscard]] Cell merged(SiteNumber i, SiteNumber j, std::span<const std::size_t> which) const;
  void weigh(SiteNumber site);

  const Metric& metric_;
  PointsView<Scalar> points_;
  std::span<const double> masses_;
  std::span<const double> capacities_;
  SiteState sites_;
  double coordinate_bound_;
  double heaviest_ = 0;
  std::vector<Cell> cells_;
  std::vector<double> held_;
  std::vector<double> margin_;
};

extern template class MassCells<float>;
extern template class MassCells<double>;

}  // namespace ccvt
