#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"
#include "numbers.h"

namespace ccvt {

/// How many points each of `sites` sites owns.
inline std::vector<Index> cell_sizes(std::span<const Index> owners, std::size_t sites) {
  std::vector<Index> sizes(sites, 0);
  for (const Index owner : owners) ++sizes[SiteNumber(owner)];
  return sizes;
}

}  // namespace ccvt
