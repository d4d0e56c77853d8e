#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "exact/pricing.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "parallel/rank_part.h"

namespace ccvt {

/// Of each cell, whether its points, on any rank, are not what they were.
std::vector<std::uint8_t> changed_cells(std::span<const Index> before, std::span<const Index> after,
                                        std::size_t cells, Ranks* ranks = nullptr);

/// Moves each site to the centroid of its points, in double; a site without points stays.
/// `changed`: of each cell whether to look at it; none: at all of them.
///
/// Of several ranks, each adds its points to what the lower ones have come to, so that sums are
/// those of one process to the bit: a run of cells at a time, so that all are at work, on different
/// runs. Where all have all points and the arena divides loops among them, they take turns in the
/// cells. The sums take 8 (D + 1) bytes a cell that is looked at, from rank to rank and to all.
template <class Scalar>
void move_to_centroids(const Metric& metric, PointsView<Scalar> points, const Grouping& groups,
                       const Arena& arena, std::vector<double>& sites,
                       std::span<const std::uint8_t> changed = {}, Ranks* ranks = nullptr);

/// For sites that are compared by distance alone: a weight of nothing each.
inline std::vector<double> no_weights(const std::vector<double>& sites, int dimension) {
  std::vector<double> weights(sites.size() / static_cast<std::size_t>(dimension), 0.0);
  return weights;
}

/// The nearest site of every point; exact. Of several ranks, all call it.
template <class Scalar>
std::vector<Index> nearest_owners(const Metric& metric, PointsView<Scalar> points,
                                  const std::vector<double>& sites, const Arena& arena,
                                  const RankPart& part = {});

}  // namespace ccvt
