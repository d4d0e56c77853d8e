#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {

/// The capacities of `sites` sites, for points that are in groups 0, 1, …, those of a group in a
/// row. Each group gets as many sites as it has of the points, rounded so that the sum is right
/// [largest remainders], and these own its points, with capacities that differ by at most 1: those
/// of one group after the other. Points of groups that get none go to the sites of the largest.
std::vector<Index> share_capacities(std::span<const Index> groups, Index sites);

}  // namespace ccvt
