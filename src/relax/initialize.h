#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/filling.h"
#include "relax/levels.h"
#include "relax/site_state.h"
#include "schedule/schedule.h"

namespace ccvt {

/// Each of these gives the `joining` points their first owners and fills the cells exactly. Points
/// of a coarser level are in `filling` already. When the arena throws Stopped, those in `filling`
/// are some of the joining ones, each once, and the sites as they were.

/// Each point, in a seeded random order, takes the nearest site with room left [Program 6].
/// O(m log n): the tree forgets sites as they fill up. Points take their sites one by one; what is
/// nearest is looked up ahead, for several at the same time.
template <class Scalar>
void join_coherent(const Metric& metric, const SiteState& sites,
                   std::span<const PointNumber> joining, std::uint64_t seed,
                   Filling<Scalar>& filling, const Arena& arena = Arena(1));

/// Each point takes its nearest site whether or not it has room; then balance(). `near` are pairs
/// of sites near each other, if any are known; of several ranks, those of each one's sites.
template <class Scalar>
void join_balanced(const Metric& metric, const SiteState& sites, const Box& box,
                   const JoiningPoints& joining, std::span<const Pair> near, const Arena& arena,
                   Filling<Scalar>& filling);

/// Random owners [Program 1].
template <class Scalar>
void join_random(std::span<const PointNumber> joining, std::uint64_t seed, Filling<Scalar>& filling,
                 const Arena& arena = Arena(1));

}  // namespace ccvt
