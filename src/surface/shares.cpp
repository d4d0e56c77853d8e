#include "surface/shares.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace ccvt {

std::vector<Share> share_sites(std::span<const Index> groups, Index sites) {
  const auto all = static_cast<Index>(groups.size());
  std::vector<Share> shares;
  for (Index p = 0; p < all; ++p) {
    const auto at = static_cast<std::size_t>(p);
    if (p == 0 || groups[at] != groups[at - 1]) shares.push_back({p, 0, 0});
    ++shares.back().points;
  }
  // Whole sites first, then one more for each of those with the largest remainders.
  Index left = sites;
  for (Share& share : shares) {
    share.sites = static_cast<Index>(std::int64_t{share.points} * sites / all);
    left -= share.sites;
  }
  std::vector<std::size_t> order(shares.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const auto remainder = [&](const Share& s) { return std::int64_t{s.points} * sites % all; };
    return remainder(shares[a]) > remainder(shares[b]);
  });
  for (std::size_t k = 0; left > 0; ++k, --left) ++shares[order[k]].sites;

  std::vector<Share> merged;
  for (const Share& share : shares) {
    const bool joins = !merged.empty() && (share.sites == 0 || merged.back().sites == 0);
    if (!joins) {
      merged.push_back(share);
      continue;
    }
    merged.back().points += share.points;
    merged.back().sites += share.sites;
  }
  return merged;
}

}  // namespace ccvt
