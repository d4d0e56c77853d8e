#include "exact/grouping.h"

#include <algorithm>
#include <utility>

namespace ccvt {
namespace {

/// Points of a slice, for each site that it counts them for.
constexpr std::size_t kPointsPerCount = 4;

}  // namespace

Grouping::Grouping(std::span<const Index> owners, std::size_t sites, const Arena& arena)
    : order(owners.size()), offset(sites + 1, 0) {
  const std::size_t slices =
      std::clamp<std::size_t>(owners.size() / (kPointsPerCount * std::max<std::size_t>(sites, 1)),
                              1, static_cast<std::size_t>(arena.threads()));
  const std::size_t size = (owners.size() + slices - 1) / slices;
  const auto for_slices = [&](const auto& look) {
    arena.for_each(slices, 1, [&](std::size_t slice) {
      const std::size_t end = std::min((slice + 1) * size, owners.size());
      for (std::size_t p = slice * size; p < end; ++p) {
        look(PointNumber(p), slice * sites + SiteNumber(owners[p]));
      }
    });
  };
  // Of each slice and site: how many points; then where the next one goes.
  std::vector<std::size_t> next(slices * sites, 0);
  for_slices([&](PointNumber, std::size_t at) { ++next[at]; });
  std::size_t before = 0;
  for (std::size_t s = 0; s < sites; ++s) {
    offset[s] = before;
    for (std::size_t at = s; at < next.size(); at += sites) {
      before += std::exchange(next[at], before);
    }
  }
  offset[sites] = before;
  for_slices([&](PointNumber p, std::size_t at) { order[next[at]++] = p; });
}

}  // namespace ccvt
