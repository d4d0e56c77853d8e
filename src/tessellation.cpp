#include "ccvt/tessellation.h"

#include <numeric>
#include <string>

#include "numbers.h"

namespace ccvt {

Tessellation::Tessellation(std::span<const Index> owners, Index sites) : order_(owners.size()) {
  if (sites < 1) throw InvalidInput("sites: " + std::to_string(sites) + " is not positive");
  offset_.assign(static_cast<std::size_t>(sites) + 1, 0);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    if (owners[p] < 0 || owners[p] >= sites) {
      throw InvalidInput("owners[" + std::to_string(p) + "] is " + std::to_string(owners[p]) +
                         ": it must be in 0.." + std::to_string(sites - 1));
    }
    ++offset_[SiteNumber(owners[p]) + 1];
  }
  std::partial_sum(offset_.begin(), offset_.end(), offset_.begin());
  std::vector<std::size_t> next(offset_.begin(), offset_.end() - 1);
  for (const PointNumber p : points_below(owners.size())) {
    order_[next[SiteNumber(owners[p])]++] = p.index();
  }
}

}  // namespace ccvt
