#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>

#include "ccvt/ranks.h"
#include "ccvt/types.h"
#include "number_text.h"
#include "numbers.h"

namespace ccvt {

/// How many points several ranks have at most in all: each as many as Index can number.
inline std::int64_t most_points(const Ranks& ranks) {
  return std::min(kMostPointsOfAll,
                  ranks.count() * std::int64_t{std::numeric_limits<Index>::max()});
}

/// sites * points_per_site. Throws InvalidInput when `sites` is less than 1, or they make more than
/// `most` points. `points_per_site` >= 1.
inline std::int64_t checked_point_count(Index sites, Index points_per_site, std::int64_t most) {
  const std::int64_t points = std::int64_t{sites} * points_per_site;
  if (sites < 1) throw InvalidInput(concat("sites: is ", sites, "; must be at least 1"));
  if (points > most) {
    throw InvalidInput(concat("sites: ", sites, " with ", points_per_site, " points each make ",
                              points, " points; at most ", most, " are supported"));
  }
  return points;
}

/// The same for one process.
inline Index checked_point_count(Index sites, Index points_per_site) {
  return static_cast<Index>(
      checked_point_count(sites, points_per_site, std::numeric_limits<Index>::max()));
}

}  // namespace ccvt
