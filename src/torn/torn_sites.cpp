#include "torn/torn_sites.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tuple>
#include <utility>

#include "parallel/loops.h"
#include "parallel/together.h"
#include "relax/update.h"
#include "spatial/site_tree.h"

namespace ccvt {
namespace {

constexpr double kTorn = 2;
/// Of the mean energy of a cell: with a smaller excess a cell matters to nobody.
constexpr double kLeastExcess = 0.5;
/// Of a cell, root mean square of the distances of its points to the site, as a share of the
/// distance of that to the next one: torn ones have .67 at the least. Of white points one cell in
/// twelve has more than this with 16 points a site, and one in a hundred with 64.
constexpr double kLeastSpread = 0.6;
/// So many points of a cell are looked at.
constexpr Index kPointsOfCell = 64;

/// The distance to the next site, squared.
double squared_gap(const Metric& metric, const SiteState& sites, SiteNumber site,
                   const SiteTree& tree) {
  std::vector<Index> near;
  tree.nearest(sites.at(site), 2, near);
  const SiteNumber next(near[0] == site.index() ? near[1] : near[0]);
  return metric.squared_distance(sites.at(site), sites.at(next));
}

/// What a cell's points cost more than at the sites nearest to them, and these, when it is torn.
template <class Scalar>
TornSite look_into(const Metric& metric, const LevelState<Scalar>& state, SiteNumber site,
                   const SiteTree& tree) {
  const Cells<Scalar>& cells = state.cells;
  TornSite torn{site, 0, {}};
  double own = 0;
  double least = 0;
  std::vector<Scalar> x(cells.dimension());
  std::vector<double> query(cells.dimension());
  const Index step = (cells.size(site) + kPointsOfCell - 1) / kPointsOfCell;
  Index looked_at = 0;
  for (Index k = 0; k < cells.size(site); k += step, ++looked_at) {
    cells.get(site, k, x.data());
    std::copy(x.begin(), x.end(), query.begin());
    const SiteNumber nearest(tree.nearest(query.data()));
    own += metric.squared_distance(x.data(), state.sites.at(site));
    least += metric.squared_distance(x.data(), state.sites.at(nearest));
    torn.nearest.push_back(nearest);
  }
  if (own < kTorn * least) return torn;
  torn.excess = (own - least) / looked_at * cells.size(site);
  std::sort(torn.nearest.begin(), torn.nearest.end());
  torn.nearest.erase(std::unique(torn.nearest.begin(), torn.nearest.end()), torn.nearest.end());
  return torn;
}

/// Those that each rank has found.
std::vector<TornSite> of_all_ranks(Ranks* ranks, const std::vector<TornSite>& own) {
  struct Head {
    SiteNumber site;
    double excess;
    std::size_t nearest;
  };
  std::vector<Head> heads;
  std::vector<SiteNumber> nearest;
  for (const TornSite& t : own) {
    heads.push_back({t.site, t.excess, t.nearest.size()});
    nearest.insert(nearest.end(), t.nearest.begin(), t.nearest.end());
  }
  nearest = joined(ranks, std::move(nearest));
  std::vector<TornSite> all;
  auto next = nearest.cbegin();
  for (const Head& head : joined(ranks, std::move(heads))) {
    const auto end = next + static_cast<std::ptrdiff_t>(head.nearest);
    all.push_back({head.site, head.excess, {next, end}});
    next = end;
  }
  return all;
}

}  // namespace

template <class Scalar>
std::vector<TornSite> torn_sites(const Metric& metric, const LevelState<Scalar>& state,
                                 const Arena& arena) {
  const SiteState& sites = state.sites;
  if (sites.count() < 2) return {};
  const double least_excess =
      kLeastExcess * total_energy(sites, arena) / static_cast<double>(sites.count());
  const SiteTree tree(metric, sites.position);
  const NumberRange<SiteNumber> own = state.tiling.own_sites();
  constexpr std::size_t kSitesPerGrain = 64;
  PerWorker<std::vector<TornSite>> found(arena);
  arena.for_ranges(own.size(), kSitesPerGrain, [&](std::size_t begin, std::size_t end, int worker) {
    for (const SiteNumber s : sites_between(*own.begin() + begin, *own.begin() + end)) {
      const double size = state.cells.size(s);
      if (sites.energy[s] <= least_excess ||
          sites.energy[s] <=
              kLeastSpread * kLeastSpread * size * squared_gap(metric, sites, s, tree)) {
        continue;
      }
      TornSite torn = look_into(metric, state, s, tree);
      if (torn.excess > least_excess) found[worker].push_back(std::move(torn));
    }
  });
  std::vector<TornSite> torn;
  for (std::size_t w = 0; w < found.size(); ++w) {
    for (TornSite& t : found[static_cast<int>(w)]) torn.push_back(std::move(t));
  }
  torn = of_all_ranks(state.tiling.ranks(), torn);
  std::sort(torn.begin(), torn.end(), [](const TornSite& a, const TornSite& b) {
    return std::tuple(-a.excess, a.site) < std::tuple(-b.excess, b.site);
  });
  return torn;
}

#define CCVT_INSTANTIATE(Scalar)                                                      \
  template std::vector<TornSite> torn_sites(const Metric&, const LevelState<Scalar>&, \
                                            const Arena& arena);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
