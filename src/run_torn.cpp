// Levels on which exchanges between pairs of sites have left cells torn.
//
// Where points lie in clouds, a site may come to own half of its points in one and half in another,
// far away, and so a second site between that cloud and a third, and so on around: no exchange
// between two of them gains, but one all around would. Such cells last through all levels, at
// several times the energy. An assignment that is optimal for all sites at once has none, nor, but
// for few, one that is for the sites around them.
#include <algorithm>
#include <cstddef>
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
/// both.
constexpr double kMostSites = 512;
constexpr double kMostPoints = 1 << 16;
constexpr double kMostCoordinates = 1 << 25;
/// With fewer, cells that are torn together do not come together.
constexpr double kLeastSites = 64;

double excess_of(const std::vector<TornSite>& torn) {
  double excess = 0;
  for (const TornSite& t : torn) excess += t.excess;
  return excess;
}

}  // namespace

/// How many sites are looked at together on this level; none: it is not looked at.
template <class Scalar>
std::size_t Run<Scalar>::torn_window() const {
  if (options.pairs != PairSelection::meeting) return 0;
  const double sites = problem.site_count();
  const double capacity = static_cast<double>(state.cells.point_count()) / sites;
  const double most = std::min({sites, kMostSites, kMostPoints / capacity,
                                kMostCoordinates / (capacity * problem.dimension())});
  return most < std::min(sites, kLeastSites) ? 0 : static_cast<std::size_t>(most);
}

/// At the end of a level: where cells are torn, points around them get the owners, and sites the
/// places, of a tessellation whose assignment is optimal there. Whether there were any. When it
/// throws Stopped, nothing has changed.
template <class Scalar>
bool Run<Scalar>::mend_torn_cells() {
  const std::size_t most = torn_window();
  if (most == 0) return false;
  const auto timed = record.relaxing();
  std::vector<TornSite> torn;
  const auto windows_in = [&](const LevelState<Scalar>& tessellation) -> std::vector<Window> {
    torn = torn_sites(metric, tessellation, arena);
    const double energy = total_energy(tessellation.sites, arena);
    if (!(excess_of(torn) - turns.excess > kWorthIt * energy)) return {};
    return windows_around(metric, tessellation.sites, torn, most);
  };
  std::vector<Window> windows = windows_in(state);
  if (windows.empty()) return false;
  LevelState<Scalar> mended{state.tiling, state.sites, empty_cells(levels[level].capacities)};
  for_each_site(arena, state.tiling,
                [&](SiteNumber s) { mended.cells.copy_points(state.cells, s); });
  bool gains = false;
  for (std::vector<Window> before; windows != before;) {
    for (const Window& window : windows) gains = mend(metric, window, mended, arena) || gains;
    before = std::exchange(windows, windows_in(mended));
  }
  if (!gains) return false;
  turns.excess = excess_of(torn);
  std::unique_ptr<Relaxer<Scalar>> next = make_relaxer();  // that of now knows the old cells
  state = std::move(mended);
  relaxer = std::move(next);
  const Stop::Pause pause(stop);
  update_all(metric, state, arena);
  return true;
}

#define CCVT_INSTANTIATE(Scalar)                         \
  template std::size_t Run<Scalar>::torn_window() const; \
  template bool Run<Scalar>::mend_torn_cells();

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
