#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// In so many dimensions at most greed pays, and is affordable.
constexpr int kGreedyDimensions = 8;

/// Greedy k-means++ [Arthur, Vassilvitskii 2007]: sites are drawn from the points with
/// probability proportional to the squared distance to those drawn before; of several draws the one
/// that leaves the least energy is taken. In more than kGreedyDimensions there is one draw.
///
/// A result for each stream of random numbers, the same whichever others are asked for. All go
/// through the points together, which are read once for all of them. O(m n D) a stream and draw.
std::vector<std::vector<double>> plus_plus(PointsView<float> points, Index sites,
                                           std::uint64_t seed,
                                           std::span<const std::uint64_t> streams,
                                           const Arena& arena = Arena(1));

/// The same without the greed, in rounds: each draws as many sites as there are already, and then
/// looks at the distances to all of them at once [as k-means||: Bahmani et al. 2012].
/// O(m n D), in blocked products, divided among the arena's ranks.
std::vector<double> plus_plus_in_rounds(PointsView<float> points, Index sites, std::uint64_t seed,
                                        std::uint64_t stream, const Arena& arena = Arena(1));

}  // namespace ccvt
