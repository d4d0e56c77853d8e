#pragma once

#include <array>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/loops.h"
#include "relax/site_state.h"
#include "spatial/site_bins.h"
#include "spatial/site_tree.h"

namespace ccvt {

/// A point and the site nearest to it, with a copy of the point's coordinates unless `Dimension` is
/// 0: reading these at random costs more than carrying them along.
template <class Scalar, std::size_t Dimension>
struct Near {
  SiteNumber site;  ///< while points are sorted: a cell of the grid
  PointNumber point;
  std::array<Scalar, Dimension> x;
};
template <class Scalar>
struct Near<Scalar, 0> {
  SiteNumber site;
  PointNumber point;
};

/// Finds the nearest site for many points; exact.
///
/// In two and three dimensions the points are sorted by the bins of a grid, and for each bin the
/// few sites are found that can be nearest to any point of it. Elsewhere, and in bins where sites
/// crowd or are far, a k-d tree is asked.
template <class Scalar>
class NearestSites {
 public:
  /// Keeps references to `metric` and `sites`.
  NearestSites(const Metric& metric, const SiteState& sites, const Box& box,
               const Arena& arena = Arena(1));

  /// The number of dimensions whose coordinates come along: 2 or 3 with a grid, else 0.
  [[nodiscard]] std::size_t dimension_of_copies() const { return bins_ ? dimension_ : 0; }

  /// The order in which find() leaves points of a grid: by this, and then by their numbers.
  [[nodiscard]] std::size_t cell_count() const { return bins_->bin_count() << dimension_; }
  [[nodiscard]] std::size_t cell_of(const Scalar* x) const;

  /// What find() finds, and memory that it needs: both last from one call to the next.
  template <std::size_t Dimension>
  struct Found {
    Buffer<Near<Scalar, Dimension>> points;
    Buffer<Near<Scalar, Dimension>> spare;
  };
  /// `Dimension` is dimension_of_copies(). Of points in a grid, neighbours are near each other.
  template <std::size_t Dimension>
  void find(const PointsView<Scalar>& points, std::span<const PointNumber> which,
            const Arena& arena, Found<Dimension>& found) const;

  /// The site nearest to each of all points, by point.
  [[nodiscard]] Buffer<SiteNumber> owners(const PointsView<Scalar>& points,
                                          const Arena& arena) const;

 private:
  static constexpr std::size_t kMostDimensions = SiteBins::kMostDimensions;
  using Vector = std::array<double, kMostDimensions>;
  struct Around;
  struct Worker;

  template <std::size_t Dimension>
  [[nodiscard]] std::size_t cell_of(const Scalar* position) const;
  [[nodiscard]] Vector centre_of(std::size_t bin) const;
  template <std::size_t Dimension>
  [[nodiscard]] bool gather(const Vector& centre, Around& around) const;
  template <std::size_t Dimension>
  void keep_candidates(const Around& around, const Vector& centre, double halves,
                       Around& candidates) const;
  template <std::size_t Dimension>
  void find_in_bin(std::size_t bin, Worker& worker, Groups<Near<Scalar, Dimension>>& by_cell) const;
  template <std::size_t Dimension>
  void find_among(const Around& candidates, const Vector& centre, Worker& worker,
                  std::span<Near<Scalar, Dimension>> here) const;

  [[nodiscard]] const SiteTree& tree() const;

  const Metric& metric_;
  const SiteState& sites_;
  Vector extent_{};  ///< of the torus; infinite in Euclidean space
  std::size_t dimension_ = 0;
  mutable std::once_flag tree_built_;  ///< most never ask it
  mutable std::optional<SiteTree> tree_;
  std::optional<SiteBins> bins_;
  /// A bin has 2^D cells.
  Vector lower_{};
  Vector inverse_width_{};  ///< of a cell
  Vector last_{};           ///< cell along each dimension
  Vector half_{};           ///< of a bin's width, with room for rounding
};

/// Calls visit.template operator()<Dimension>() with the number of dimensions in place.
template <class Visit>
auto with_dimension(std::size_t dimension, const Visit& visit) {
  if (dimension == 2) return visit.template operator()<2>();
  if (dimension == 3) return visit.template operator()<3>();
  return visit.template operator()<0>();
}

extern template class NearestSites<float>;
extern template class NearestSites<double>;

}  // namespace ccvt
