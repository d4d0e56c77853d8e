// Levels on which exchanges between pairs of sites have left cells torn.
//
// Where points lie in clouds, a site may come to own half of its points in one and half in another,
// far away, and so a second site between that cloud and a third, and so on around: no exchange
// between two of them gains, but one all around would. Such cells last through all levels, at
// several times the energy. An assignment that is optimal for all sites at once has none, nor, but
// for few, one that is for the sites around them.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "relax/update.h"
#include "run.h"
#include "torn/mend.h"
#include "torn/torn_sites.h"
#include "torn/windows.h"

namespace ccvt {
namespace {

/// Cells are mended when the torn ones have so much of the energy to lose, more than was left to
/// them when they were last mended on this level.
constexpr double kWorthIt = 0.01;
/// Windows have so many sites at most, and so many points, as what an assignment takes grows with
/// both; with fewer sites, cells that are torn together do not come together.
constexpr double kMostSites = 512;
constexpr double kLeastSites = 64;
constexpr double kMostPoints = 1 << 16;
constexpr double kMostCoordinates = 1 << 25;
/// In means of all capacities: among much larger cells an assignment takes ten times as long, and
/// gains nothing.
constexpr double kMostCapacity = 32;
/// All windows of a round take no longer than the level has, or a tenth of a second or two: about a
/// microsecond per squared number of sites.
constexpr double kWorkPerPoint = 4;
constexpr double kLeastWork = 1 << 19;
/// Where capacities differ much, points cost more than at the nearest sites, and no assignment
/// changes that. So windows around cells that have less to lose are left when one gained less of
/// the energy than this; and rounds are made as long as each gains so much.
constexpr double kLeastOfWindow = 3e-3;
constexpr double kLeastOfRound = 5e-3;
constexpr int kMostRounds = 4;

double excess_of(const std::vector<TornSite>& torn) {
  double excess = 0;
  for (const TornSite& t : torn) excess += t.excess;
  return excess;
}

}  // namespace

/// What windows on this level may have; no sites: it is not looked at.
template <class Scalar>
WindowLimits Run<Scalar>::torn_windows() const {
  // What is torn around sites that stay where they are would be so again.
  const bool move = 2 * problem.fixed_sites().cols() < problem.site_count();
  if (options.pairs != PairSelection::meeting || !move) return {};
  const double sites = problem.site_count();
  const auto points = static_cast<double>(state.cells.point_count());
  const double most_points = std::min(kMostPoints, kMostCoordinates / problem.dimension());
  const double most = std::min({sites, kMostSites, most_points * sites / points});
  if (most < std::min(sites, kLeastSites)) return {};
  const double capacity = std::min(most_points, std::ceil(kMostCapacity * points / sites));
  return {static_cast<std::size_t>(most), static_cast<std::int64_t>(most_points),
          static_cast<Index>(capacity), std::max(kLeastWork, kWorkPerPoint * points)};
}

/// At the end of a level: where cells are torn, points around them get the owners, and sites the
/// places, of a tessellation whose assignment is optimal there. Whether that gained. When it throws
/// Stopped, nothing has changed.
template <class Scalar>
bool Run<Scalar>::mend_torn_cells() {
  const WindowLimits most = torn_windows();
  if (most.sites == 0) return false;
  const auto timed = record.relaxing();
  const auto charge = arena.phase(Phase::mend);
  const auto torn_now = [&](const SiteTree& tree) {
    std::vector<TornSite> torn = torn_sites(metric, state, tree, arena);
    std::erase_if(
        torn, [&](const TornSite& t) { return levels[level].capacities[t.site] > most.capacity; });
    return torn;
  };
  std::unique_ptr<Relaxer<Scalar>> next;  // that of now knows the old cells
  std::vector<Unmended<Scalar>> undo;
  try {
    for (int round = 0; round < kMostRounds; ++round) {
      const SiteTree tree(metric, state.sites.position);
      const std::vector<TornSite> torn = torn_now(tree);
      const double energy = total_energy(state.sites, arena);
      if (!(excess_of(torn) - turns.excess > kWorthIt * energy)) break;
      double gained = 0;
      for (const Window& window :
           windows_around(state.sites, tree, levels[level].capacities, torn, most)) {
        const double gain = mend(metric, window, state, arena, undo);
        gained += gain;
        if (!(gain > kLeastOfWindow * energy)) break;
      }
      if (!(gained > kLeastOfRound * energy)) break;
    }
    if (undo.empty()) return false;
    next = make_relaxer(levels[level].capacities);
  } catch (...) {
    restore(undo, state);
    throw;
  }
  relaxer = std::move(next);
  const Stop::Pause pause(stop);
  update_all(metric, state, arena);
  turns.excess = excess_of(torn_now(SiteTree(metric, state.sites.position)));
  record.begin(energy_of_sites(), false);
  return true;
}

#define CCVT_INSTANTIATE(Scalar)                           \
  template WindowLimits Run<Scalar>::torn_windows() const; \
  template bool Run<Scalar>::mend_torn_cells();

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
