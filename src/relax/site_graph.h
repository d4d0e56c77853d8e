#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/loops.h"
#include "relax/site_state.h"
#include "relax/spanning_tree.h"
#include "schedule/pair.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Those of `pairs` whose diametral ball holds no third site that is paired with the first: the
/// Gabriel graph, a connected part of the Delaunay graph, when `pairs` holds all of that. By their
/// first site. Of several ranks each gives at least the pairs of its own sites (see own_pairs.h),
/// and all get all. O(pairs * degree).
Buffer<Pair> gabriel_pairs(const Metric& metric, const SiteState& sites,
                           std::span<const Pair> pairs, const Tiling& tiling,
                           const Arena& arena = Arena(1));

/// A connected, undirected graph of sites.
class SiteGraph {
 public:
  /// `edges`: each once. Where they leave the graph unconnected, sites with consecutive numbers
  /// are joined.
  SiteGraph(std::size_t sites, std::span<const Pair> edges, const Arena& arena = Arena(1));

  [[nodiscard]] std::size_t site_count() const { return neighbours_.count(); }
  /// Ascending.
  [[nodiscard]] std::span<const SiteNumber> neighbours(SiteNumber site) const {
    return neighbours_[site];
  }
  [[nodiscard]] const Groups<SiteNumber>& all_neighbours() const { return neighbours_; }

  [[nodiscard]] const SpanningTree& spanning_tree() const { return tree_; }

 private:
  Groups<SiteNumber> neighbours_;
  SpanningTree tree_;
};

}  // namespace ccvt
