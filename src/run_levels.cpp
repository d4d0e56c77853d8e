// The levels of a run: how their points get owners, and what they are lowered by.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bounds.h"
#include "descent/descent.h"
#include "parallel/loops.h"
#include "parallel/stop.h"
#include "relax/along_curve.h"
#include "relax/deal.h"
#include "relax/initialize.h"
#include "relax/levels.h"
#include "relax/moved_points.h"
#include "relax/relaxer.h"
#include "relax/update.h"
#include "run.h"

namespace ccvt {
namespace {

/// So many coordinates are divided into levels, and join, within hundredths of a second: too soon
/// for a run to end in between. What is not balanced takes longer.
constexpr std::int64_t kFewCoordinates = std::int64_t{1} << 18;
constexpr std::int64_t kFewUnbalanced = std::int64_t{1} << 14;
/// A step of a descent is small when it lowers the energy by less than this share, divided by the
/// points a site on the finest level: the more of them, the longer do pairs take for what is left.
/// With 4096 a site, where it is 3e-4, a third of it makes 1024 sites take 1.4 times as long, and
/// end .15 % lower; with 65536 three times the least makes them take longer.
constexpr double kGainTimesPoints = 1.2;
constexpr double kLeastGain = 1e-4;
constexpr double kMostLeastGain = 3e-4;
/// And from each descent of a level to the next by this.
constexpr double kSmallerGain = 0.25;
/// Of the patience with pairs, what is left of it when a level has been descended again.
constexpr double kMoreImpatient = 4;

}  // namespace

/// The points of each level, and what their sites hold.
template <class Scalar>
void Run<Scalar>::divide_points() {
  const auto charge = arena.phase(Phase::levels);
  std::vector<Index> capacities;
  capacities.reserve(site_of.size());
  for (const SiteNumber given : site_of) capacities.push_back(problem.capacities()[given]);
  levels.resize(1);
  levels[0].capacities = capacities;
  std::vector<Level> made = make_levels(capacities, options);
  const auto first = static_cast<std::size_t>(problem.first_own_point());
  if (made.size() > 1) {
    PointsAlongCurve<Scalar> along(own_points(), problem.point_count(),
                                   box_around_points(problem, arena), arena);
    share_points(made, along, first, options.seed, arena);
  }
  levels = std::move(made);
  if (ranks() == nullptr) return;
  for (Level& each : levels) {
    each.joining.keep_own(first, first + static_cast<std::size_t>(problem.points().count));
  }
}

/// Of this rank's sites, for points of all.
template <class Scalar>
Cells<Scalar> Run<Scalar>::empty_cells(const std::vector<Index>& sizes) const {
  return {problem.dimension(), sizes, state.tiling.own_sites(), problem.point_count()};
}

template <class Scalar>
void Run<Scalar>::take_owners() {
  std::vector<SiteNumber> rank(site_of.size());
  for (const SiteNumber k : state.sites.all()) rank[site_of[k]] = k;
  state.cells = empty_cells(levels[0].capacities);
  const OwnPoints<Scalar> points = own_points();
  Filling<Scalar> filling(state.cells, points, state.tiling);
  const auto for_own = [&](const auto& add) {
    for (std::size_t k = 0; k < problem.initial_owners().size(); ++k) {
      add(rank[SiteNumber(problem.initial_owners()[k])], PointNumber(k));
    }
  };
  if (ranks() == nullptr) {
    for_own([&](SiteNumber site, PointNumber p) { filling.add(site, p); });
  } else {
    MovedPoints<Scalar> moved(filling);  // the ranks' points follow each other
    for_own([&](SiteNumber site, PointNumber p) { moved.send(points.of_all(p), points[p], site); });
    moved.arrive(arena);
  }
  relaxer = make_relaxer(levels[0].capacities);
  begin_level();
}

/// Gives the joining points owners by the chosen initialization.
template <class Scalar>
void Run<Scalar>::join(const JoiningPoints& joining, std::span<const Pair> near,
                       Filling<Scalar>& filling) {
  const auto charge = arena.phase(Phase::join);
  switch (options.initialization) {
    case Initialization::automatic:  // decided by resolved()
    case Initialization::balanced:
      return join_balanced(metric, state.sites, around, joining, near, arena, filling);
    case Initialization::coherent:
      return join_coherent(metric, state.sites, joining.all(arena), options.seed, filling, arena);
    case Initialization::random:
      return join_random(joining.all(arena), options.seed, filling, arena);
  }
}

/// What keeps the caller from being asked while so few points join that it would only cost him
/// their owners; nothing where there are more.
template <class Scalar>
std::optional<Stop::Pause> Run<Scalar>::pause_for(std::int64_t points) {
  const bool balanced = options.initialization == Initialization::balanced;
  const std::int64_t most = balanced ? kFewCoordinates : kFewUnbalanced;
  if (points > most / problem.dimension()) return {};
  return std::optional<Stop::Pause>(std::in_place, stop);
}

/// Lets the points of the next level join the cells. When the run is cancelled meanwhile, and they
/// do not come to an end soon, all points are dealt out.
template <class Scalar>
void Run<Scalar>::enter_level(std::size_t next) {
  const auto timed = record.initializing();
  const Buffer<Pair> near = relaxer ? relaxer->listed() : Buffer<Pair>{};
  Cells<Scalar> larger = empty_cells(levels[next].capacities);
  Filling<Scalar> filling(larger, own_points(), state.tiling);
  if (level < next) {
    const auto charge = arena.phase(Phase::join);
    const Stop::Pause pause(stop);
    for_each_site(arena, state.tiling, [&](SiteNumber s) { filling.add_cell(state.cells, s); });
  }
  relaxer = make_relaxer(levels[next].capacities);  // lists of pairs take much memory
  state.cells = {};
  level = next;
  try {
    const auto pause = pause_for(static_cast<std::int64_t>(levels[level].joining.size()));
    // Points that went where there is room may cost a hundred times as much.
    const Stop::Patience to_the_end(stop, kTimeToFinish);
    join(levels[level].joining, near, filling);
  } catch (const Stopped&) {
    return deal(larger, filling.filled);
  } catch (...) {
    if (ranks() != nullptr) throw;  // no rank has all points, and whoever catches it ends them all
    deal(larger, filling.filled);
    end(Termination::cancelled);
    throw;
  }
  state.cells = std::move(larger);
  begin_level();
}

/// Ends a cancelled run: all points get owners without more ado, and the sites stay as they are.
template <class Scalar>
void Run<Scalar>::deal(const Cells<Scalar>& owned, std::span<const Index> filled) {
  const auto timed = record.relaxing();
  stop.off();
  const std::int64_t points = problem.point_count();
  const std::int64_t joined = std::accumulate(filled.begin(), filled.end(), std::int64_t{0});
  record.summary().warnings.push_back(
      "the run ended before all points had joined: " + std::to_string(points - joined) + " of " +
      std::to_string(points) +
      " went to sites that had room, and sites are not at the centroids of their cells");
  dealt = deal_rest(metric, state.sites, around, problem.points(), levels.back().capacities, owned,
                    filled);
  level = levels.size() - 1;
  state.cells = {};
  relaxer.reset();
  const double energy = sum_of(arena, dealt.size(), kPointsPerGrain, [&](std::size_t p) {
    return metric.squared_distance(problem.points()[PointNumber(p).index()],
                                   state.sites.at(dealt[p]));
  });
  record.begin(energy, true);
}

template <class Scalar>
std::unique_ptr<Relaxer<Scalar>> Run<Scalar>::make_relaxer(std::span<const Index> sizes) {
  return std::make_unique<Relaxer<Scalar>>(metric, options, arena, stop, sizes, coordinate_bound);
}

/// Of a step of a descent of a level that has had some before.
template <class Scalar>
double Run<Scalar>::least_gain(int before) const {
  const double share =
      kGainTimesPoints * problem.site_count() / static_cast<double>(problem.point_count());
  return std::clamp(share, kLeastGain, kMostLeastGain) * std::pow(kSmallerGain, before);
}

template <class Scalar>
void Run<Scalar>::begin_descent(Depth depth, double energy) {
  weights.resize(state.sites.count(), 0.0);
  descent = std::make_unique<Descent<Scalar>>(metric, arena, stop, own_points(), state, depth,
                                              least_gain(turns.descents), weights);
  ++turns.descents;
  turns.passes = 0;
  turns.before = energy;
}

/// At the end of a descent. When it gained less than pairs had before it, it was the last.
template <class Scalar>
void Run<Scalar>::leave_to_pairs(double energy) {
  const double by_pairs = turns.after - turns.before;
  const bool again = turns.descents > 1;
  if (again && !(turns.before - energy > by_pairs)) turns.descents = kMostDescents;
  turns.after = energy;
}

/// After a pass over pairs that did not end the level: whether to descend again.
template <class Scalar>
bool Run<Scalar>::pairs_creep() const {
  const double most = turns.descents > 1 ? patience / kMoreImpatient : patience;
  return on_finest_level() && turns.passes >= most && turns.descents > 0 &&
         turns.descents < kMostDescents && descends() == Depth::full;
}

template <class Scalar>
void Run<Scalar>::descend_again(double energy) {
  const auto timed = record.relaxing();
  relaxer = make_relaxer(levels[level].capacities);  // it knows the cells as they are now
  begin_descent(Depth::full, energy);
}

/// All points of the level are in cells, and `relaxer` knows nothing yet: the sites move to their
/// centroids.
template <class Scalar>
void Run<Scalar>::begin_level() {
  {
    const Stop::Pause pause(stop);
    update_all(metric, state, arena);
  }
  turns = {};
  const double energy = energy_of_sites();
  if (const std::optional<Depth> depth = descends()) begin_descent(*depth, energy);
  record.begin(energy, on_finest_level());
}

/// Whether this level is lowered by Descent, and how far.
template <class Scalar>
std::optional<Depth> Run<Scalar>::descends() const {
  constexpr double kTimesAsManyOnFinest = 4;
  const double least = static_cast<double>(options.descent_points) * problem.site_count();
  if (options.descent_points == 0 || options.pairs != PairSelection::meeting ||
      static_cast<double>(state.cells.point_count()) < least) {
    return {};
  }
  if (options.until == Until::blue_noise && level > 0) return Depth::even;
  if (static_cast<double>(problem.point_count()) >= kTimesAsManyOnFinest * least) {
    return Depth::full;
  }
  if (on_finest_level() && level > 0) return Depth::brief;
  return {};
}

#define CCVT_INSTANTIATE(Scalar)                                                                  \
  template void Run<Scalar>::divide_points();                                                     \
  template Cells<Scalar> Run<Scalar>::empty_cells(const std::vector<Index>&) const;               \
  template void Run<Scalar>::take_owners();                                                       \
  template void Run<Scalar>::join(const JoiningPoints&, std::span<const Pair>, Filling<Scalar>&); \
  template std::optional<Stop::Pause> Run<Scalar>::pause_for(std::int64_t);                       \
  template void Run<Scalar>::enter_level(std::size_t);                                            \
  template void Run<Scalar>::deal(const Cells<Scalar>&, std::span<const Index>);                  \
  template std::unique_ptr<Relaxer<Scalar>> Run<Scalar>::make_relaxer(std::span<const Index>);    \
  template void Run<Scalar>::begin_level();                                                       \
  template std::optional<Depth> Run<Scalar>::descends() const;                                    \
  template double Run<Scalar>::least_gain(int) const;                                             \
  template void Run<Scalar>::begin_descent(Depth, double);                                        \
  template void Run<Scalar>::leave_to_pairs(double);                                              \
  template bool Run<Scalar>::pairs_creep() const;                                                 \
  template void Run<Scalar>::descend_again(double);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
