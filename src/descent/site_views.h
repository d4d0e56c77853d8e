#pragma once

#include <span>
#include <vector>

#include "geometry/metric.h"
#include "kernels/power.h"
#include "parallel/loops.h"
#include "relax/cells.h"
#include "schedule/pair.h"

namespace ccvt {

/// Positions of sites, as steps from where they were first seen, and their weights: a point p
/// belongs to the site s with the least |p - s|^2 - weight.
struct PowerDiagram {
  std::vector<double> step;  ///< dimension values for each site
  std::vector<double> weight;
};

/// Sites as they are seen from the cells near them: relative to a reference of the cell, so that a
/// torus needs no further thought, and float will do. Views of a cell are numbered one after the
/// other, that of its own site first.
template <class Scalar>
class SiteViews {
 public:
  using View = Number<struct OfViews>;

  SiteViews(const Metric& metric, const Arena& arena)
      : metric_(metric), arena_(arena), dimension_(metric.coordinate_count()) {}

  /// Looks at sites from cells: `position` and `radius` are the sites' own, and bound the cells;
  /// `near` holds all pairs of sites whose cells can meet, each once. `thresholds`: of each cell,
  /// how much nearer a site may come to its points, in power, before move() says so.
  void look(const Cells<Scalar>& cells, std::span<const double> position,
            std::span<const double> radius, std::span<const double> weight,
            std::span<const Pair> near, std::span<const double> thresholds);

  /// Moves the views of a cell to where the diagram has the sites. Returns how much of its
  /// threshold that takes up, at most: below 1 no point that was farther than the threshold from
  /// all borders of the cell has changed its owner.
  double move(SiteNumber cell, const PowerDiagram& diagram);

  [[nodiscard]] NumberRange<View> of(SiteNumber cell) const {
    return {View(first_[cell]), View(first_[cell + 1])};
  }
  [[nodiscard]] View own(SiteNumber cell) const { return View(first_[cell]); }
  [[nodiscard]] std::size_t count(SiteNumber cell) const { return first_[cell + 1] - first_[cell]; }
  [[nodiscard]] std::size_t count() const { return site_.size(); }
  [[nodiscard]] SiteNumber site(View view) const { return site_[view]; }
  /// The view of the cell's own site from the cell of the view's site.
  [[nodiscard]] View twin(View view) const { return twin_[view]; }
  /// Where the site is, relative to the cell's reference.
  [[nodiscard]] const double* at(View view) const { return &now_[view * dimension_]; }
  [[nodiscard]] double squared_distance(View view) const;

  [[nodiscard]] kernels::PowerSites<Scalar> seen_from(SiteNumber cell) const {
    return {&slope_[first_[cell] * dimension_], &offset_[first_[cell]],
            static_cast<Index>(count(cell))};
  }
  /// A coordinate relative to the cell's reference.
  [[nodiscard]] Scalar relative(SiteNumber cell, Scalar x, std::size_t d) const {
    const double reference = reference_[cell * dimension_ + d];
    return static_cast<Scalar>(metric_.wrap(x - reference, d));
  }
  /// The same for a stream of them.
  void relative(SiteNumber cell, std::size_t d, std::span<const Scalar> x, Scalar* out) const {
    const Scalar reference = reference_[cell * dimension_ + d];
    if (metric_.periodic()) {
      const double extent = metric_.extent()[d];
      for (std::size_t k = 0; k < x.size(); ++k) {
        out[k] = static_cast<Scalar>(shortest_difference(double{x[k]} - reference, extent));
      }
    } else {
      // One rounding, as that of a difference of doubles.
      for (std::size_t k = 0; k < x.size(); ++k) out[k] = x[k] - reference;
    }
  }

 private:
  void link(std::size_t sites, std::span<const Pair> near);
  void place(SiteNumber cell, std::span<const double> position, double radius,
             std::span<const double> weight, double threshold);
  [[nodiscard]] double gap(SiteNumber cell, View view, std::span<const double> weight) const {
    return squared_distance(view) - squared_distance(own(cell)) - weight[site_[view]] +
           weight[cell];
  }

  const Metric& metric_;
  const Arena& arena_;
  std::size_t dimension_;

  std::vector<std::size_t> first_;  ///< view of each cell, and one more
  std::vector<SiteNumber> site_;
  std::vector<View> twin_;
  std::vector<double> first_at_;  ///< where the site was when it was first seen
  std::vector<double> now_;
  std::vector<double> first_gap_;  ///< of power at the reference, to the own site's
  std::vector<double> room_;       ///< how much the power of a point to it may fall
  std::vector<Scalar> slope_;      ///< as the kernels want them
  std::vector<Scalar> offset_;
  std::vector<Scalar> reference_;  ///< of each cell, a position near the site
  std::vector<double> reach_;      ///< of the cell's points from it
};

extern template class SiteViews<float>;
extern template class SiteViews<double>;

}  // namespace ccvt
