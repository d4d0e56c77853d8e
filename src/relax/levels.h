#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/options.h"
#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/buffer.h"

namespace ccvt {

/// One level of the multi-level optimisation [5.2].
struct Level {
  std::vector<Index> capacities;  ///< of the sites on this level
  Buffer<PointNumber> joining;    ///< points that join here, ascending
};

/// Splits the points into nested random subsets: level l holds the points that join on levels
/// 0..l, as many as its capacities sum to, each subset of that size equally likely. On the last
/// level all points have joined and capacities are those given. One level without
/// Options::multilevel, or when capacities are too small to divide. O(m).
std::vector<Level> make_levels(std::span<const Index> capacities, Index points,
                               const Options& options, const Arena& arena = Arena(1));

}  // namespace ccvt
