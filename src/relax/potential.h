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

}  // namespace ccvt
