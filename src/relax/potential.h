#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"
#include "relax/site_graph.h"

namespace ccvt {

/// The potential phi with L phi = e, where L is the graph's Laplacian, to 0.25 in every residual.
/// `e` sums to zero. About O(sites + edges) when consecutive sites lie close together: conjugate
/// gradients, preconditioned by a multigrid cycle over aggregates of sites [Vanek, Mandel, Brezina
/// 1996; unsmoothed, Braess 1995].
std::vector<double> potential(const SiteGraph& graph, std::span<const Index> e,
                              const Arena& arena = Arena(1));

/// A graph of sites with a weight on each edge, which both of its ends list.
struct WeightedGraph {
  std::vector<std::size_t> first;  ///< edge of each site, and one more
  std::vector<SiteNumber> neighbour;
  std::vector<float> weight;
};

/// The same for the Laplacian of a weighted graph, to a hundredth of the largest e, or to 0.25.
std::vector<double> potential(const WeightedGraph& graph, std::span<const double> e,
                              const Arena& arena = Arena(1));

}  // namespace ccvt
