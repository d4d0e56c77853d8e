#include "relax/site_order.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>

namespace ccvt {
namespace {

struct Part {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Sites that a task should have at least.
constexpr std::size_t kSitesPerGrain = 1024;

}  // namespace

/// All parts of one size are split at the same time.
std::vector<Index> spatial_order(const std::vector<double>& positions, int dimension,
                                 Index tile_sites, const Arena& arena) {
  const auto extent = static_cast<std::size_t>(dimension);
  const auto tile = static_cast<std::size_t>(tile_sites);
  std::vector<Index> order(positions.size() / extent);
  std::iota(order.begin(), order.end(), 0);
  const auto coordinate = [&](Index site, std::size_t d) {
    return positions[static_cast<std::size_t>(site) * extent + d];
  };
  const auto widest_side = [&](const Part& part) {
    std::size_t widest = 0;
    double width = -1;
    for (std::size_t d = 0; d < extent; ++d) {
      double low = coordinate(order[part.begin], d);
      double high = low;
      for (std::size_t k = part.begin + 1; k < part.end; ++k) {
        low = std::min(low, coordinate(order[k], d));
        high = std::max(high, coordinate(order[k], d));
      }
      if (high - low > width) {
        width = high - low;
        widest = d;
      }
    }
    return widest;
  };
  const auto middle_of = [&](const Part& part) {
    const std::size_t size = part.end - part.begin;
    if (size > tile) return part.begin + (size - 1 + tile) / tile / 2 * tile;
    return part.begin + std::bit_ceil(size) / 2;
  };
  const auto split = [&](const Part& part) {
    const std::size_t along = widest_side(part);
    const auto at = [&](std::size_t k) { return order.begin() + static_cast<std::ptrdiff_t>(k); };
    std::nth_element(at(part.begin), at(middle_of(part)), at(part.end), [&](Index a, Index b) {
      const double x = coordinate(a, along);
      const double y = coordinate(b, along);
      return x != y ? x < y : a < b;
    });
  };
  std::vector<Part> parts{{0, order.size()}};
  while (!parts.empty()) {
    const std::size_t grain = 1 + kSitesPerGrain * parts.size() / order.size();
    arena.for_each(parts.size(), grain, [&](std::size_t p) {
      if (parts[p].end - parts[p].begin > 1) split(parts[p]);
    });
    std::vector<Part> halves;
    for (const Part& part : parts) {
      if (part.end - part.begin <= 2) continue;
      halves.push_back({part.begin, middle_of(part)});
      halves.push_back({middle_of(part), part.end});
    }
    parts = std::move(halves);
  }
  return order;
}

}  // namespace ccvt
