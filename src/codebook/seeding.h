#pragma once

#include <cstdint>
#include <vector>

#include "ccvt/types.h"
#include "codebook/vectors.h"
#include "parallel/arena.h"

namespace ccvt {

constexpr int kRestarts = 4;
/// With more sites than this, chance hardly tells one seeding from another: the best of four leaves
/// Lloyd's distortion .2 % lower in the plane, that of exact assignments no lower. One will do; and
/// a smaller sample where there are more than kGreedyDimensions.
constexpr Index kFewSites = 128;

/// Good first codewords for Euclidean `points`: of `restarts` seedings, each improved on a sample
/// by Lloyd iterations and by merging and splitting cells, the one of least energy; 0 restarts: as
/// many as pay. One after the other, `dimension` values each. When the arena throws Stopped
/// meanwhile, the best there are so far, or distinct points; then the stop of the arena is still
/// on.
/// Ranks divide what there is to do on the sample, which all of them have.
template <class Scalar>
std::vector<double> seed_sites(const Vectors<Scalar>& points, Index sites, int restarts,
                               std::uint64_t seed, const Arena& arena);

/// Distinct points: of `restarts` draws, 0 being kRestarts, the one of least sampled_energy(). The
/// best so far when the arena throws Stopped. All ranks draw the same, and
/// divide the sample.
template <class Scalar>
std::vector<double> draw_sites(const Vectors<Scalar>& points, Index sites, int restarts,
                               std::uint64_t seed, const Arena& arena);

/// The sum of squared distances to the nearest of `sites` over a sample of the points.
template <class Scalar>
double sampled_energy(const Vectors<Scalar>& points, const std::vector<double>& sites,
                      std::uint64_t seed, const Arena& arena);

}  // namespace ccvt
