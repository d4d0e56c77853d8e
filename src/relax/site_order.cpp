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
std::vector<SiteNumber> spatial_order(const SiteState& sites, Index tile_sites,
                                      const Arena& arena) {
  const auto tile = static_cast<std::size_t>(tile_sites);
  std::vector<SiteNumber> order(sites.count());
  std::iota(order.begin(), order.end(), SiteNumber(0));
  const auto widest_side = [&](const Part& part) {
    std::size_t widest = 0;
    double width = -1;
    for (std::size_t d = 0; d < sites.dimension; ++d) {
      double low = sites.at(order[part.begin])[d];
      double high = low;
      for (std::size_t k = part.begin + 1; k < part.end; ++k) {
        low = std::min(low, sites.at(order[k])[d]);
        high = std::max(high, sites.at(order[k])[d]);
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
    SiteNumber* const first = order.data();
    std::nth_element(first + part.begin, first + middle_of(part), first + part.end,
                     [&](SiteNumber a, SiteNumber b) {
                       const double x = sites.at(a)[along];
                       const double y = sites.at(b)[along];
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
