#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/site_state.h"
#include "spatial/site_bins.h"
#include "spatial/site_tree.h"

namespace ccvt {

/// Finds the nearest site for many points; exact.
///
/// In two and three dimensions the points are sorted by the bins of a grid, and for each bin the
/// few sites are found that can be nearest to any point of it. Elsewhere, and in bins where sites
/// crowd or are far, a k-d tree is asked.
template <class Scalar>
class NearestSites {
 public:
  /// Keeps references to `metric` and `sites`.
  NearestSites(const Metric& metric, const SiteState& sites, const Box& box);

  /// Points, neighbours near each other, and the site nearest to each.
  struct Found {
    std::vector<Index> point;
    std::vector<Index> site;
  };
  /// Called with begin and end of consecutive ranges of what is found, so that it can be used
  /// while it is in the cache.
  using Taken = std::function<void(std::size_t, std::size_t)>;
  /// `found` is made anew; `taken` may be empty.
  void operator()(const PointsView<Scalar>& points, std::span<const Index> which,
                  const Arena& arena, Found& found, const Taken& taken = {}) const;

 private:
  static constexpr std::size_t kMostDimensions = SiteBins::kMostDimensions;
  using Vector = std::array<double, kMostDimensions>;
  struct Around;
  struct Worker;

  template <std::size_t Dimension>
  [[nodiscard]] std::uint32_t cell_of(const Scalar* position) const;
  void sort_by_cell(const PointsView<Scalar>& points, std::span<const Index> which,
                    const Arena& arena, std::vector<std::size_t>& first, Found& found) const;
  [[nodiscard]] Vector centre_of(std::size_t bin) const;
  template <std::size_t Dimension>
  [[nodiscard]] bool gather(const Vector& centre, Around& around) const;
  template <std::size_t Dimension>
  void keep_candidates(const Around& around, const Vector& centre, double halves,
                       Around& candidates) const;
  template <std::size_t Dimension>
  void find_in_bin(const PointsView<Scalar>& points, std::span<const std::size_t> first,
                   std::size_t bin, Worker& worker, Found& found) const;
  template <std::size_t Dimension>
  void find_among(const PointsView<Scalar>& points, const Around& candidates, const Vector& centre,
                  std::size_t begin, std::size_t end, Worker& worker, Found& found) const;
  void ask_tree(const PointsView<Scalar>& points, std::size_t begin, std::size_t end,
                Found& found) const;

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

extern template class NearestSites<float>;
extern template class NearestSites<double>;

}  // namespace ccvt
