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
/// In two and three dimensions the box is cut into blocks, one a site, and these into 2^D cells;
/// for each cell the few sites are kept that can be nearest to any point of it. Elsewhere, and in
/// blocks where sites crowd or are far, a k-d tree is asked.
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
  static constexpr std::size_t kMostDimensions = 3;
  struct SitesByBlock {
    std::vector<std::size_t> first;  ///< of block b: site[first[b]] .. site[first[b + 1] - 1]
    std::vector<Index> site;
    std::vector<double> position;
  };
  /// A site, as seen from the centre of a block.
  struct Offset {
    Index site;
    double squared;
    std::array<double, kMostDimensions> from_centre;
  };

  template <int Dimension>
  void look_up(const PointsView<Scalar>& points, std::span<const Index> which, Index* owner) const;

  void make_grid(const Box& box, const Arena& arena);
  bool cut_into_blocks(const Box& box);
  [[nodiscard]] SitesByBlock sort_by_block(std::size_t blocks) const;
  [[nodiscard]] std::size_t cell_of(const double* position) const;
  void sites_around(const SitesByBlock& sites, const Index* place, const double* centre,
                    std::vector<Offset>& around) const;
  void candidates_of(const std::vector<Offset>& around, const double* centre, double cells_wide,
                     std::vector<Offset>& near) const;
  template <class Visit>
  void for_ring(const Index* centre, Index ring, Visit visit) const;

  const Metric& metric_;
  const SiteState& sites_;
  SiteTree tree_;

  std::vector<Index> blocks_;  ///< along each dimension; none: no grid
  std::vector<double> lower_;
  std::vector<double> width_;  ///< of a cell, half a block
  std::vector<double> inverse_width_;
  std::vector<double> slack_width_;  ///< of a cell, with room for rounding
  double least_width_ = 0;
  double diagonal_ = 0;  ///< of a block, with room for rounding
  /// The candidates of cell g are those from begin_[g] to begin_[g + 1]; none: ask the tree.
  std::vector<std::uint32_t> begin_;
  std::vector<Index> candidate_;
  std::vector<double> position_;  ///< of the candidates: of their image nearest to the cell
};

extern template class NearestSites<float>;
extern template class NearestSites<double>;

}  // namespace ccvt
