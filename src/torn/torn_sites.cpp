#include "torn/torn_sites.h"

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <utility>

#include "parallel/loops.h"
#include "parallel/together.h"
#include "relax/update.h"

namespace ccvt {
namespace {

/// Points of a torn cell cost more than so many times what they would at the sites nearest to them,
/// or, of a small cell, than one time and so many of its points: white ones cost as much by chance.
/// And so much of the mean energy of a cell more: without that it matters to nobody.
constexpr double kTorn = 1.3;
constexpr double kByChance = 12;
constexpr double kLeastExcess = 0.2;
/// Seen by so many of its points; or not to be, by far fewer.
constexpr Index kPointsToTell = 64;
constexpr Index kPointsToDoubt = 16;
constexpr double kDoubtful = 1.1;

/// The distance to the next site, squared.
double squared_gap(const Metric& metric, const SiteState& sites, SiteNumber site,
                   const SiteTree& tree) {
  std::vector<Index> near;
  tree.nearest(sites.at(site), 2, near);
  const SiteNumber next(near[0] == site.index() ? near[1] : near[0]);
  return metric.squared_distance(sites.at(site), sites.at(next));
}

/// What a cell's points cost more than at the sites nearest to them, and these, told from so many
/// of them; nothing when they do not cost so many times as much.
template <class Scalar>
TornSite look_into(const Metric& metric, const LevelState<Scalar>& state, SiteNumber site,
                   const SiteTree& tree, Index points, double times) {
  const Cells<Scalar>& cells = state.cells;
  TornSite torn{site, 0, {}};
  double own = 0;
  double least = 0;
  std::vector<Scalar> x(cells.dimension());
  std::vector<double> query(cells.dimension());
  const Index step = (cells.size(site) + points - 1) / points;
  for (Index k = 0; k < cells.size(site); k += step) {
    cells.get(site, k, x.data());
    std::copy(x.begin(), x.end(), query.begin());
    const SiteNumber nearest(tree.nearest(query.data()));
    own += metric.squared_distance(x.data(), state.sites.at(site));
    least += metric.squared_distance(x.data(), state.sites.at(nearest));
    torn.nearest.push_back(nearest);
  }
  if (!(own > times * least)) return torn;
  torn.excess = (own - least) / static_cast<double>(torn.nearest.size()) * cells.size(site);
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
                                 const SiteTree& tree, const Arena& arena) {
  const SiteState& sites = state.sites;
  if (sites.count() < 2) return {};
  const double least_excess =
      kLeastExcess * total_energy(sites, arena) / static_cast<double>(sites.count());
  const NumberRange<SiteNumber> own = state.tiling.own_sites();
  constexpr std::size_t kSitesPerGrain = 64;
  PerWorker<std::vector<TornSite>> found(arena);
  arena.for_ranges(own.size(), kSitesPerGrain, [&](std::size_t begin, std::size_t end, int worker) {
    for (const SiteNumber s : sites_between(*own.begin() + begin, *own.begin() + end)) {
      if (sites.energy[s] <= least_excess) continue;
      const double radius = sites.radius[s];
      if (radius * radius <= squared_gap(metric, sites, s, tree)) continue;
      if (!(look_into(metric, state, s, tree, kPointsToDoubt, kDoubtful).excess > 0)) continue;
      const double times = std::max(kTorn, 1 + kByChance / state.cells.size(s));
      TornSite torn = look_into(metric, state, s, tree, kPointsToTell, times);
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
                                            const SiteTree&, const Arena&);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
