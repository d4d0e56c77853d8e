#include "ccvt/tessellation.h"

#include <numeric>
#include <string>

namespace ccvt {

Tessellation::Tessellation(std::span<const Index> owners, Index sites) : order_(owners.size()) {
  if (sites < 1) throw InvalidInput("sites: " + std::to_string(sites) + " is not positive");
  offset_.assign(static_cast<std::size_t>(sites) + 1, 0);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    if (owners[p] < 0 || owners[p] >= sites) {
      throw InvalidInput("owners[" + std::to_string(p) + "] is " + std::to_string(owners[p]) +
                         ": it must be in 0.." + std::to_string(sites - 1));
    }
    ++offset_[static_cast<std::size_t>(owners[p]) + 1];
  }
  std::partial_sum(offset_.begin(), offset_.end(), offset_.begin());
  std::vector<Index> next(offset_.begin(), offset_.end() - 1);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    const auto place = next[static_cast<std::size_t>(owners[p])]++;
    order_[static_cast<std::size_t>(place)] = static_cast<Index>(p);
  }
}

}  // namespace ccvt
