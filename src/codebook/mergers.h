#pragma once

#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "numbers.h"
#include "parallel/arena.h"

namespace ccvt {

/// A cell, and the one that it is merged with.
struct Merger {
  double cost = std::numeric_limits<double>::infinity();  ///< by how much the energy rises
  SiteNumber i, j;
};

/// With more sites than this, the cheapest merger may be missed for one nearly as cheap: each is
/// compared with so many of the nearest.
constexpr std::size_t kExactMergers = 8192;
constexpr std::size_t kComparedMergers = 1024;

/// For each cell the other that it is merged with at the least cost, the first of several: with a
/// and b points the two cost a b / (a + b) times the squared distance of their centroids [Ward
/// 1963]. `sites`: the centroids, one after the other; `size`: of each cell. A site alone has
/// itself. O(n^2 D) up to kExactMergers sites, O(n D) times kComparedMergers beyond, and
/// O(n^1.5 D); divided among the arena's ranks.
std::vector<Merger> cheapest_mergers(std::span<const double> sites, std::size_t dimension,
                                     std::span<const double> size, const Arena& arena);

}  // namespace ccvt
