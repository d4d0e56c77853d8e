#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {

/// Points in a row, and how many sites they get.
struct Share {
  Index first = 0;
  Index points = 0;
  Index sites = 0;
};

/// For points that are in groups 0, 1, …, those of a group in a row: each group gets as many sites
/// as it has of the points, rounded so that the sum is right [largest remainders]. Groups that get
/// none go with the one before them, or else with the one behind.
std::vector<Share> share_sites(std::span<const Index> groups, Index sites);

}  // namespace ccvt
