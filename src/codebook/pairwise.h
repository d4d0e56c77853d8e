#pragma once

#include <span>
#include <vector>

#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

struct PairwiseCells {
  std::vector<Index> owners;
  Termination termination;
};

/// What tessellate() makes of the vectors, from `sites`, one after the other; for coordinates of
/// any magnitude alike.
template <class Scalar>
PairwiseCells pairwise_cells(PointsView<Scalar> vectors, std::span<const double> sites,
                             std::vector<Index> capacities, Options options, const Arena& arena);

}  // namespace ccvt
