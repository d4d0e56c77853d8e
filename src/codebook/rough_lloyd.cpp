#include "codebook/rough_lloyd.h"

#include <cstddef>

#include "exact/centroids.h"
#include "exact/grouping.h"
#include "exact/move_costs.h"
#include "parallel/rank_turns.h"

namespace ccvt {
namespace {

constexpr int kIterations = 12;
/// Bounds of cells are kept in no fewer dimensions than this, and for no more sites. With 256 of
/// 784 dimensions seeding takes .6 of the time so, with 1024 of 64 dimensions .75; in fewer
/// dimensions nothing is gained, and with 4096 sites of 96 dimensions it takes two thirds or twice
/// the time, as the points lie.
constexpr int kLeastDimensions = 8;
constexpr std::size_t kMostSites = 1024;

}  // namespace

RoughLloyd::RoughLloyd(const Metric& metric, PointsView<float> points, Index sites,
                       const Arena& arena)
    : metric_(metric),
      points_(points),
      arena_(arena),
      weights_(static_cast<std::size_t>(sites), 0.0),
      pricer_(metric, points, arena) {
  if (points.dimension < kLeastDimensions || weights_.size() > kMostSites) return;
  kept_.emplace(static_cast<std::size_t>(points.count), weights_.size(),
                RankTurns(sharing(arena, {})));
}

void RoughLloyd::relax(Seeds& seeds) {
  for (int i = 0; i < kIterations; ++i) {
    const double before = seeds.energy;
    const Prices prices = price(seeds);
    seeds.energy = prices.cheapest_energy;
    if (prices.moved == 0 || (i > 0 && before - seeds.energy < kRough * before)) break;
    move_to_centroids(metric_, points_, Grouping(seeds.owners, weights_.size(), arena_), arena_,
                      seeds.sites);
  }
}

Prices RoughLloyd::price(Seeds& seeds) {
  if (!kept_) return pricer_.price({seeds.sites, weights_}, seeds.owners);
  if (!priced_.empty()) {
    kept_->include_all(seeds.owners, SquaredDistances<float>(metric_, points_, priced_), arena_);
  }
  priced_ = seeds.sites;
  return pricer_.price({seeds.sites, weights_}, seeds.owners, &*kept_);
}

}  // namespace ccvt
