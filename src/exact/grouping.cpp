#include "exact/grouping.h"

#include <numeric>

namespace ccvt {

Grouping::Grouping(std::span<const Index> owners, std::size_t sites)
    : order(owners.size()), offset(sites + 1, 0) {
  for (const Index owner : owners) ++offset[SiteNumber(owner) + 1];
  std::partial_sum(offset.begin(), offset.end(), offset.begin());
  std::vector<std::size_t> next(offset.begin(), offset.end() - 1);
  for (const PointNumber p : points_below(owners.size())) order[next[SiteNumber(owners[p])]++] = p;
}

}  // namespace ccvt
