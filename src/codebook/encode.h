#pragma once

#include <vector>

#include "ccvt/types.h"
#include "exact/pricing.h"
#include "parallel/arena.h"

namespace ccvt {

/// For each point the site of least |p - s|^2 - weight, Euclidean and exact. `part`: the points are
/// those of a rank; others need not call.
template <class Scalar>
std::vector<Index> cheapest_sites(PointsView<Scalar> points, const WeightedSites& sites,
                                  const Arena& arena, const RankPart& part = {});

}  // namespace ccvt
