#pragma once

#include <cstdint>

#include "ccvt/ranks.h"

namespace ccvt {

/// Which of the points of all ranks those are that a function is given: this rank's, the first of
/// which has this number among all. Without ranks, all are there.
struct RankPart {
  Ranks* ranks = nullptr;
  std::int64_t first = 0;
};

}  // namespace ccvt
