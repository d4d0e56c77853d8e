#include "surface/shares.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

namespace ccvt {

namespace {

std::vector<std::int64_t> count(std::span<const Index> groups) {
  const Index last = *std::max_element(groups.begin(), groups.end());
  std::vector<std::int64_t> points(static_cast<std::size_t>(last) + 1);
  for (const Index group : groups) ++points[static_cast<std::size_t>(group)];
  return points;
}

/// Whole sites first, then one more for each of those with the largest remainders.
std::vector<Index> share_sites(const std::vector<std::int64_t>& points, Index sites,
                               std::int64_t all) {
  std::vector<Index> share(points.size());
  Index left = sites;
  for (std::size_t g = 0; g < points.size(); ++g) {
    share[g] = static_cast<Index>(points[g] * sites / all);
    left -= share[g];
  }
  std::vector<std::size_t> order(points.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return points[a] * sites % all > points[b] * sites % all;
  });
  for (std::size_t k = 0; left > 0; ++k, --left) ++share[order[k]];
  return share;
}

}  // namespace

std::vector<Index> share_capacities(std::span<const Index> groups, Index sites) {
  std::vector<std::int64_t> points = count(groups);
  const std::vector<Index> share = share_sites(points, sites, std::ssize(groups));
  const auto largest =
      static_cast<std::size_t>(std::max_element(share.begin(), share.end()) - share.begin());
  for (std::size_t g = 0; g < points.size(); ++g) {
    if (share[g] > 0) continue;
    points[largest] += points[g];
    points[g] = 0;
  }
  std::vector<Index> capacities;
  for (std::size_t g = 0; g < points.size(); ++g) {
    for (std::int64_t s = 0; s < share[g]; ++s) {
      const std::int64_t begin = s * points[g] / share[g];
      capacities.push_back(static_cast<Index>((s + 1) * points[g] / share[g] - begin));
    }
  }
  return capacities;
}

}  // namespace ccvt
