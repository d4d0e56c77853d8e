#pragma once

#include <cstddef>
#include <cstdint>

#include "ccvt/types.h"
#include "parallel/loops.h"
#include "parallel/rank_part.h"

namespace ccvt {

/// Points that all ranks have, such as a sample, and the part of them that each looks at.
template <class Scalar>
struct Divided {
  PointsView<Scalar> own;
  RankPart part;

  /// No ranks: all are one's own.
  Divided(PointsView<Scalar> all, Ranks* ranks) : own(all) {
    constexpr std::size_t kGrain = 64;
    const RankRange range(ranks, static_cast<std::size_t>(all.count), kGrain);
    own.data += static_cast<std::ptrdiff_t>(range.begin) * all.stride;
    own.count = static_cast<Index>(range.end - range.begin);
    part = {ranks, static_cast<std::int64_t>(range.begin)};
  }
};

}  // namespace ccvt
