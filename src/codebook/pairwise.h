#pragma once

#include <vector>

#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"
#include "codebook/vectors.h"
#include "parallel/arena.h"

namespace ccvt {

struct PairwiseCells {
  std::vector<Index> owners;
  Termination termination = Termination::running;
};

/// What tessellate() makes of the vectors, from `sites`, one after the other; for coordinates of
/// any magnitude alike. Sites that are outside of the box around the vectors, from which sums would
/// lose digits, move to its faces before. Of several ranks, owners are those of a rank's own(), and
/// `all` are gathered.
template <class Scalar>
PairwiseCells pairwise_cells(const Vectors<Scalar>& vectors, PointsView<Scalar> all,
                             std::vector<double>& sites, std::vector<Index> capacities,
                             Options options, const Arena& arena);

}  // namespace ccvt
