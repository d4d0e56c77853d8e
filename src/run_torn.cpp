// Levels on which exchanges between pairs of sites have left cells torn.
//
// Where points lie in clouds, a site may come to own half of its points in one and half in another,
// far away, and so a second site between that cloud and a third, and so on around: no exchange
// between two of them gains, but one all around would. Such cells last through all levels, at
// several times the energy. An assignment that is optimal for all sites at once has none.
#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

#include "exact/assignment.h"
#include "exact/centroids.h"
#include "exact/grouping.h"
#include "parallel/together.h"
#include "relax/nearest_sites.h"
#include "relax/update.h"
#include "run.h"

namespace ccvt {
namespace {

/// Of the energy that points had at their nearest sites: beyond this share cells are taken to be
/// torn. White points have 1.05 with 16 points a site, and 1.02 with 64; those in clouds that
/// overlap 1.05 to 1.1 when no cell is torn.
constexpr double kTorn = 1.1;
/// Levels of so many points a site, or of so many points in all, are looked at; finer ones only
/// rarely get torn cells that they did not begin with. And so many coordinates are copied.
constexpr double kMostPointsASite = 100;
constexpr double kFewPoints = 1 << 16;
constexpr double kMostCoordinates = 1 << 25;
/// What an assignment takes grows with the square of the sites, and little of it is done in
/// parallel: two seconds with so many. With four times as many sites as the finest level has points
/// a site it takes about two times as long as all the rest does on one thread.
constexpr double kMostSites = 2048;
constexpr double kMostSitesPerPointASite = 4;
/// What the first assignment gains, of the energy, where cells are torn; else it is for nothing:
/// capacities differ, or points are denser here than there.
constexpr double kGainOfTorn = 0.01;
/// Rounds of assigning and of moving sites end when one gains no more than this share.
constexpr double kLeastGain = 1e-3;
constexpr int kMostRounds = 32;

/// The points of a level, on all ranks: cell after cell.
template <class Scalar>
struct PointsOfLevel {
  PointsOfLevel(const Cells<Scalar>& cells, const Tiling& tiling) : dimension(cells.dimension()) {
    std::size_t own = 0;
    for (const SiteNumber s : tiling.own_sites()) own += static_cast<std::size_t>(cells.size(s));
    number.reserve(own);
    coordinates.reserve(own * dimension);
    for (const SiteNumber s : tiling.own_sites()) {
      for (Index k = 0; k < cells.size(s); ++k) {
        number.push_back(cells.point(s, k));
        coordinates.resize(coordinates.size() + dimension);
        cells.get(s, k, &coordinates[coordinates.size() - dimension]);
      }
    }
    number = joined(tiling.ranks(), std::move(number));
    coordinates = joined(tiling.ranks(), std::move(coordinates));
    for (const SiteNumber s : cells.sites()) {
      owner.insert(owner.end(), static_cast<std::size_t>(cells.size(s)), s.index());
    }
  }
  [[nodiscard]] PointsView<Scalar> view() const {
    return {coordinates.data(), static_cast<int>(dimension), static_cast<Index>(number.size()),
            static_cast<std::ptrdiff_t>(dimension)};
  }
  [[nodiscard]] const Scalar* at(std::size_t p) const { return &coordinates[p * dimension]; }

  std::size_t dimension;
  std::vector<PointOfAll> number;
  std::vector<Scalar> coordinates;
  std::vector<Index> owner;
};

/// The sum of squared distances of points to these sites.
template <class Scalar, class SiteOf>
double energy_of(const Metric& metric, const PointsView<Scalar>& points,
                 const std::vector<double>& sites, const SiteOf& site_of) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  double energy = 0;
  for (Index p = 0; p < points.count; ++p) {
    energy += metric.squared_distance(points[p],
                                      &sites[static_cast<std::size_t>(site_of(p)) * dimension]);
  }
  return energy;
}

/// Puts the sites that are fixed back to where they are in `given`.
void keep_fixed(const SiteState& given, std::vector<double>& sites) {
  for (const SiteNumber s : given.all()) {
    if (given.is_fixed(s)) std::copy_n(given.at(s), given.dimension, &sites[s * given.dimension]);
  }
}

}  // namespace

/// Whether this level is looked at.
template <class Scalar>
bool Run<Scalar>::may_be_torn() const {
  const double sites = problem.site_count();
  const auto points = static_cast<double>(state.cells.point_count());
  return options.pairs == PairSelection::meeting && sites <= kMostSites &&
         sites * sites <= kMostSitesPerPointASite * static_cast<double>(problem.point_count()) &&
         points <= std::max(kFewPoints, kMostPointsASite * sites) &&
         points * problem.dimension() <= kMostCoordinates;
}

/// Whether points cost much more at their owners than at the sites nearest to them.
template <class Scalar>
bool Run<Scalar>::seems_torn(const PointsView<Scalar>& points) {
  const NearestSites<Scalar> search(metric, state.sites, around, arena);
  const Buffer<SiteNumber> nearest = search.owners(points, arena);
  const double least = energy_of(metric, points, state.sites.position, [&](Index p) {
    return nearest[static_cast<std::size_t>(p)].index();
  });
  return energy_of_sites() > kTorn * least;
}

/// At the end of a coarse level: where cells are torn, points get the owners, and sites the places,
/// of a tessellation whose assignment is optimal. False when the run was cancelled meanwhile: then
/// nothing has changed.
template <class Scalar>
bool Run<Scalar>::mend_torn_cells() try {
  if (!may_be_torn()) return true;
  const auto timed = record.relaxing();
  PointsOfLevel<Scalar> points(state.cells, state.tiling);
  if (!any(ranks(), seems_torn(points.view()))) return true;
  std::vector<double> sites = state.sites.position;
  std::vector<double> prices(state.sites.count(), 0.0);
  ExactAssignment<Scalar> assignment(metric, points.view(), problem.site_count(),
                                     levels[level].capacities, arena);
  double energy = energy_of_sites();
  for (int round = 0; round < kMostRounds; ++round) {
    assignment.improve(sites, prices, points.owner);
    const double before = std::exchange(
        energy, energy_of(metric, points.view(), sites,
                          [&](Index p) { return points.owner[static_cast<std::size_t>(p)]; }));
    const double gain = (before - energy) / before;
    move_to_centroids(metric, points.view(), Grouping(points.owner, prices.size()), arena, sites);
    keep_fixed(state.sites, sites);
    if (round == 0 && !(gain >= kGainOfTorn)) return true;
    if (!(gain >= kLeastGain)) break;  // nor where nothing costs anything
  }
  Cells<Scalar> cells = empty_cells(levels[level].capacities);
  std::vector<Index> filled(prices.size(), 0);
  for (std::size_t p = 0; p < points.owner.size(); ++p) {
    const SiteNumber s(points.owner[p]);
    if (!state.tiling.is_own(state.tiling.tile_of(s))) continue;
    cells.put(s, filled[s]++, points.number[p], points.at(p));
  }
  std::unique_ptr<Relaxer<Scalar>> next = make_relaxer();  // that of now knows the old cells
  state.cells = std::move(cells);
  state.sites.position = std::move(sites);
  relaxer = std::move(next);
  const Stop::Pause pause(stop);
  update_all(metric, state, arena);
  return true;
} catch (const Stopped&) {
  return false;
}

#define CCVT_INSTANTIATE(Scalar)                                    \
  template bool Run<Scalar>::may_be_torn() const;                   \
  template bool Run<Scalar>::seems_torn(const PointsView<Scalar>&); \
  template bool Run<Scalar>::mend_torn_cells();

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
