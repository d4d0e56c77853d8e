#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "relax/site_state.h"
#include "schedule/schedule.h"

namespace ccvt {

/// Those of `pairs` whose diametral ball holds no third site that is paired with the first: the
/// Gabriel graph, a connected part of the Delaunay graph, when `pairs` holds all of that. O(pairs *
/// degree).
std::vector<Pair> gabriel_pairs(const Metric& metric, const SiteState& sites,
                                std::span<const Pair> pairs);

/// A connected, undirected graph of sites.
class SiteGraph {
 public:
  /// `edges`: each once. Where they leave the graph unconnected, sites with consecutive numbers
  /// are joined.
  SiteGraph(Index sites, std::span<const Pair> edges);

  [[nodiscard]] Index site_count() const { return static_cast<Index>(begin_.size()) - 1; }
  /// Ascending.
  [[nodiscard]] std::span<const Index> neighbours(Index site) const {
    const auto s = static_cast<std::size_t>(site);
    return std::span(neighbour_).subspan(begin_[s], begin_[s + 1] - begin_[s]);
  }

  struct SpanningTree {
    std::vector<Index> order;   ///< every site after its parent; the root, site 0, first
    std::vector<Index> parent;  ///< of each site; of the root -1
  };
  /// Breadth first.
  [[nodiscard]] SpanningTree spanning_tree() const;

 private:
  std::vector<std::size_t> begin_;
  std::vector<Index> neighbour_;
};

}  // namespace ccvt
