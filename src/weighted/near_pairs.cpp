#include "weighted/near_pairs.h"

#include <algorithm>

#include "relax/site_graph.h"
#include "schedule/tiling.h"
#include "spatial/site_tree.h"

namespace ccvt {
namespace {

/// More pairs than this, and so many a site, are too many.
constexpr std::size_t kMostPairs = 1'000'000;
constexpr std::size_t kPairsPerSite = 64;
constexpr std::size_t kSitesPerGrain = 16;
/// With more pairs a site than that the Gabriel graph takes long.
constexpr std::size_t kPairsForGabriel = 32;
constexpr int kSideBySide = 8;

std::vector<Pair> nearest_pairs(const Metric& metric, const SiteState& sites, int count,
                                const Arena& arena) {
  const SiteTree tree(metric, sites.position);
  Buffer<Pair> found = collect_by_site<Pair>(
      arena, sites.count(), kSitesPerGrain, [&](SiteNumber s, std::vector<Pair>& out, int) {
        std::vector<Index> near;
        tree.nearest(sites.at(s), count + 1, near);  // and itself
        for (const Index other : near) {
          if (other != s.index()) out.push_back(Pair::ascending(s, SiteNumber(other)));
        }
      });
  const Buffer<Pair> sorted = sorted_pairs(arena, std::move(found), sites.count());
  return {sorted.begin(), sorted.end()};
}

}  // namespace

std::vector<Pair> NearPairs::list(const Metric& metric, const SiteState& sites,
                                  const Arena& arena) {
  if (!nearest_.empty()) return nearest_;
  const std::size_t limit = std::max(kMostPairs, kPairsPerSite * sites.count());
  const Tiling alone(sites.count(), 1);
  if (meeting_.refresh(metric, sites, alone, arena, limit) == MeetingPairs::Refreshed::too_many) {
    nearest_ = nearest_pairs(metric, sites, kNearest, arena);
    return nearest_;
  }
  std::vector<Pair> all(meeting_.pairs().begin(), meeting_.pairs().end());
  all.insert(all.end(), meeting_.added().begin(), meeting_.added().end());
  return all;
}

std::vector<Pair> NearPairs::side_by_side(const Metric& metric, const SiteState& sites,
                                          const Arena& arena) {
  const std::vector<Pair> near = list(metric, sites, arena);
  if (!nearest_.empty() || near.size() > kPairsForGabriel * sites.count()) {
    return nearest_pairs(metric, sites, kSideBySide, arena);
  }
  const Buffer<Pair> pairs = gabriel_pairs(metric, sites, near, {sites.count(), 1}, arena);
  return {pairs.begin(), pairs.end()};
}

}  // namespace ccvt
