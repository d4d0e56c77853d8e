#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/site_state.h"
#include "spatial/site_tree.h"

namespace ccvt {

/// Finds the nearest site for many points; exact.
///
/// In two and three dimensions a grid with four cells per site holds the few sites that can be
/// nearest to any point of a cell. Elsewhere, and in cells where sites crowd or are far, a k-d tree
/// is asked.
template <class Scalar>
class NearestSites {
 public:
  /// `queries`: how many points will be asked for; a grid pays for itself only when they are many.
  NearestSites(const Metric& metric, const SiteState& sites, const Box& box, std::size_t queries,
               const Arena& arena);

  /// owner[k] becomes the site nearest to points[which[k]].
  void operator()(const PointsView<Scalar>& points, std::span<const Index> which,
                  Index* owner) const;

 private:
  template <int Dimension, bool Periodic>
  void look_up(const PointsView<Scalar>& points, std::span<const Index> which, Index* owner) const;

  void make_grid(const Box& box, const Arena& arena);
  [[nodiscard]] std::size_t cell_of(const double* position) const;
  void sites_near(const std::vector<std::size_t>& first, const std::vector<Index>& by_cell,
                  std::size_t cell, std::vector<Index>& near) const;
  template <class Visit>
  void for_ring(const std::vector<Index>& centre, Index ring, Visit visit) const;

  const Metric& metric_;
  const SiteState& sites_;
  SiteTree tree_;

  std::vector<double> lower_;
  std::vector<double> width_;
  std::vector<double> inverse_width_;
  std::vector<Index> resolution_;  ///< cells along each dimension; empty: no grid
  std::vector<std::uint32_t> begin_;
  std::vector<Index>
      candidate_;  ///< of grid cell g: begin_[g] .. begin_[g + 1]; none: ask the tree
  std::vector<double> position_;  ///< of the candidates
};

extern template class NearestSites<float>;
extern template class NearestSites<double>;

}  // namespace ccvt
