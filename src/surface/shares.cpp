#include "surface/shares.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace ccvt {

std::vector<Index> share_capacities(std::span<const Index> groups, Index sites) {
  const auto most = *std::max_element(groups.begin(), groups.end());
  std::vector<std::int64_t> points(static_cast<std::size_t>(most) + 1);
  for (const Index group : groups) ++points[static_cast<std::size_t>(group)];

  // Whole sites first, then one more for each of those with the largest remainders.
  const std::int64_t all = std::ssize(groups);
  std::vector<std::int64_t> share(points.size());
  std::int64_t left = sites;
  for (std::size_t g = 0; g < points.size(); ++g) {
    share[g] = points[g] * sites / all;
    left -= share[g];
  }
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a] * sites % all > points[b] * sites % all;
  });
  for (std::size_t k = 0; k < order.size() && left > 0; ++k, --left) ++share[order[k]];

  const auto largest =
      static_cast<std::size_t>(std::max_element(points.begin(), points.end()) - points.begin());
  for (std::size_t g = 0; g < points.size(); ++g) {
    if (share[g] > 0 || g == largest) continue;
    points[largest] += points[g];
    points[g] = 0;
  }
  std::vector<Index> capacities;
  for (std::size_t g = 0; g < points.size(); ++g) {
    for (std::int64_t s = 0; s < share[g]; ++s) {
      capacities.push_back(
          static_cast<Index>((s + 1) * points[g] / share[g] - s * points[g] / share[g]));
    }
  }
  return capacities;
}

}  // namespace ccvt
