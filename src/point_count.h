#pragma once

#include <cstdint>
#include <limits>
#include <string>

#include "ccvt/types.h"

namespace ccvt {

/// sites * points_per_site. Throws InvalidInput when `sites` is less than 1, or they make more
/// points than Index can number. `points_per_site` >= 1.
inline Index checked_point_count(Index sites, Index points_per_site) {
  const std::int64_t points = std::int64_t{sites} * points_per_site;
  if (sites < 1) {
    throw InvalidInput("sites: is " + std::to_string(sites) + "; must be at least 1");
  }
  if (points > std::numeric_limits<Index>::max()) {
    throw InvalidInput("sites: " + std::to_string(sites) + " with " +
                       std::to_string(points_per_site) + " points each make " +
                       std::to_string(points) + " points; at most 2147483647 are supported");
  }
  return static_cast<Index>(points);
}

}  // namespace ccvt
