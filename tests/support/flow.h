#pragma once

#include <vector>

#include "ccvt/types.h"

namespace ccvt::test {

#ifdef CCVT_TEST_FLOW
/// The least sum of squared distances of an assignment that keeps the capacities, by the network
/// simplex of LEMON on the complete bipartite graph.
double least_cost(const Points<float>& points, const std::vector<double>& sites,
                  const std::vector<Index>& capacities);
#endif

}  // namespace ccvt::test
