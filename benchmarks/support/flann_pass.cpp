#include "support/flann_pass.h"

#include <flann/algorithms/dist.h>
// FLANN's headers need this order.
#include <flann/algorithms/kdtree_single_index.h>

#include <algorithm>
#include <vector>

#include "stopwatch.h"

namespace ccvt::bench {

double flann_pass(PointsView<float> points, Index sites) {
  using Tree = flann::KDTreeSingleIndex<flann::L2_Simple<float>>;
  const auto dimension = static_cast<std::size_t>(points.dimension);
  double seconds = 0;
  {
    const Stopwatch watch(seconds);
    std::vector<float> copy;
    for (Index s = 0; s < sites; ++s) copy.insert(copy.end(), points[s], points[s] + dimension);
    Tree tree(flann::Matrix<float>(copy.data(), static_cast<std::size_t>(sites), dimension),
              flann::KDTreeSingleIndexParams(10, true));
    tree.buildIndex();
    std::vector<Index> owner(static_cast<std::size_t>(points.count));
    for (Index p = 0; p < points.count; ++p) {
      flann::KNNSimpleResultSet<float> result(1);
      tree.findNeighbors(result, const_cast<float*>(points[p]),
                         flann::SearchParams(flann::FLANN_CHECKS_UNLIMITED));
      std::size_t nearest = 0;
      float distance = 0;
      result.copy(&nearest, &distance, 1, false);
      owner[static_cast<std::size_t>(p)] = static_cast<Index>(nearest);
    }
  }
  return seconds;
}

}  // namespace ccvt::bench
