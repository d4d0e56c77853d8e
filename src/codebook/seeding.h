#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// Good first codewords for Euclidean `points`: of `restarts` seedings, each improved on a sample
/// by Lloyd iterations and by merging and splitting cells, the one of least energy. One after the
/// other, `dimension` values each. `cancelled`, when given, is asked between the steps; true takes
/// the best there is.
template <class Scalar>
std::vector<double> seed_sites(PointsView<Scalar> points, Index sites, int restarts,
                               std::uint64_t seed, const Arena& arena,
                               const std::function<bool()>& cancelled = {});

/// The sum of squared distances to the nearest of `sites` over a sample of the points.
template <class Scalar>
double sampled_energy(PointsView<Scalar> points, const std::vector<double>& sites,
                      std::uint64_t seed, const Arena& arena);

/// Greedy k-means++ [Arthur, Vassilvitskii 2007]: sites are drawn from the points with
/// probability proportional to the squared distance to those drawn before; of several draws the one
/// that leaves the least energy is taken.
std::vector<double> plus_plus(PointsView<float> points, Index sites, std::uint64_t seed,
                              std::uint64_t stream);

/// `count` distinct numbers below `total`, ascending.
std::vector<Index> draw_distinct(Index count, Index total, std::uint64_t seed,
                                 std::uint64_t stream);

}  // namespace ccvt
