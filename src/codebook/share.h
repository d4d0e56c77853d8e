#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "codebook/vectors.h"
#include "parallel/arena.h"

namespace ccvt {

/// Capacities for `count` of `total` points, no fewer than there are sites: one for each site, and
/// of what is left about the share of the others. No capacities, for equal ones: none.
std::vector<Index> share_capacities(std::span<const Index> capacities, Index total, Index count);

/// Of how many vectors the samples are that balanced training starts on, one after the other.
std::vector<Index> level_sizes(Index vectors, Index codewords);

/// `count` distinct numbers of points, of each region the same share but for rounding: the points
/// are put into an order by region, random in each, and every (m / count)-th is taken. A region is
/// the cell of a site, or of several that are near each other. Of several ranks, each gets its own
/// points' numbers, among all. O(m n D) at worst, and what linkage_order() takes.
template <class Scalar>
std::vector<Index> draw_evenly(const Vectors<Scalar>& points, const std::vector<double>& sites,
                               Index count, std::uint64_t seed, const Arena& arena);

/// Sites where capacities want them: as many in a region as its points fill. `sites`, one after the
/// other, are seeds for the same points regardless of capacities, and `owners` the nearest of them;
/// their cells are put into an order in which neighbours stay together (see linkage.h), and the
/// capacities laid along it. A cell that the middles of several capacities fall into is split into
/// as many, one without any is dropped. `capacities` sum to the number of points. O(m n D) at
/// worst, and what linkage_order() takes.
template <class Scalar>
std::vector<double> share_sites(PointsView<Scalar> points, std::span<const Index> owners,
                                const std::vector<double>& sites, std::span<const Index> capacities,
                                std::uint64_t seed, const Arena& arena);

}  // namespace ccvt
