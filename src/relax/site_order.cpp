#include "relax/site_order.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <numeric>
#include <span>
#include <utility>

#include "ccvt/ranks.h"

namespace ccvt {
namespace {

struct Part {
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Sites that a task should have at least.
constexpr std::size_t kSitesPerGrain = 1024;
/// Parts that a rank should have at least, so that all have about as many sites.
constexpr std::size_t kPartsPerRank = 8;

/// Parts that are split by one rank each, the first ones by the first.
class PartsOfRanks {
 public:
  explicit PartsOfRanks(Ranks* ranks) : ranks_(ranks) {}

  /// Leaves this rank's own, as soon as there are enough parts of `sites` for all.
  void divide(std::vector<Part>& parts, std::size_t sites) {
    if (ranks_ == nullptr || !sizes_.empty()) return;
    const auto ranks = static_cast<std::size_t>(ranks_->count());
    if (parts.size() < kPartsPerRank * ranks) return;
    const auto first_of = [&](std::size_t rank) { return parts.size() * rank / ranks; };
    const auto site_of = [&](std::size_t rank) {
      return rank == 0 ? 0 : rank == ranks ? sites : parts[first_of(rank)].begin;
    };
    for (std::size_t r = 0; r < ranks; ++r) sizes_.push_back(site_of(r + 1) - site_of(r));
    const auto own = static_cast<std::size_t>(ranks_->rank());
    parts = {parts.begin() + static_cast<std::ptrdiff_t>(first_of(own)),
             parts.begin() + static_cast<std::ptrdiff_t>(first_of(own + 1))};
  }
  /// All ranks have the order of all parts.
  void share(std::vector<SiteNumber>& order) {
    if (sizes_.empty()) return;
    for (std::size_t& bytes : sizes_) bytes *= sizeof(SiteNumber);
    ranks_->share(std::as_writable_bytes(std::span(order)), sizes_);
  }

 private:
  Ranks* ranks_;
  std::vector<std::size_t> sizes_;  ///< in sites, of each rank; none where they are not divided
};

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
  PartsOfRanks of_ranks(arena.ranks());
  while (!parts.empty()) {
    of_ranks.divide(parts, order.size());
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
  of_ranks.share(order);
  return order;
}

}  // namespace ccvt
