#include "run.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "bounds.h"
#include "descent/descent.h"
#include "parallel/loops.h"
#include "parallel/together.h"
#include "relax/deal.h"
#include "relax/initial_sites.h"
#include "relax/initialize.h"
#include "relax/levels.h"
#include "relax/moved_points.h"
#include "relax/relaxer.h"
#include "relax/site_columns.h"
#include "relax/site_order.h"
#include "relax/update.h"
#include "run_record.h"

namespace ccvt {
namespace {

/// Points of levels that a cancelled run has not reached: with more, kTimeToFinish is not tried.
constexpr Index kMostToFinish = 1 << 24;
/// So many coordinates are divided into levels, and join, within hundredths of a second: too soon
/// for a run to end in between. What is not balanced takes longer.
constexpr std::int64_t kFewCoordinates = std::int64_t{1} << 18;
constexpr std::int64_t kFewUnbalanced = std::int64_t{1} << 14;
/// What an iteration may take to its end, so that a checkpoint can be left, before a run that is to
/// stop gives it up.
constexpr std::chrono::milliseconds kTimeForIteration{10'000};
constexpr std::size_t kPointsPerGrain = std::size_t{1} << 16;

const char* name_of(Initialization initialization) {
  switch (initialization) {
    case Initialization::automatic:
      return "automatic";
    case Initialization::balanced:
      return "balanced";
    case Initialization::coherent:
      return "coherent";
    case Initialization::random:
      return "random";
  }
  return "unknown";
}

/// `one_level`: when levels have nothing to give, as owners are there or no site moves.
Options resolved(Ranks* ranks, Options options, int dimension, bool one_level) {
  agree(ranks, [&options] { options.validate(); });
  if (options.initialization == Initialization::automatic) {
    options.initialization =
        dimension <= kBalancedDimensions ? Initialization::balanced : Initialization::coherent;
  }
  if (one_level) options.multilevel = false;
  return options;
}

}  // namespace

template <class Scalar>
Run<Scalar>::Run(Problem<Scalar> given_problem, Options given_options)
    : problem((require_sites(given_problem), std::move(given_problem))),
      warm(has_initial_owners(problem)),
      options(resolved(problem.ranks(), std::move(given_options), problem.dimension(),
                       warm || problem.fixed_sites().cols() == problem.site_count())),
      // Ranks end together: see cancelled_together().
      stop(problem.ranks() ? Stop() : Stop(options.cancelled, options.time_limit)),
      stop_of_ranks(options.cancelled, options.time_limit),
      record(options),
      arena(options.threads, &stop, &record.clock()),
      domain(measured_domain(problem)),
      metric(problem.dimension(), domain) {
  arena.divide_among(ranks());
  const auto timed = record.initializing();
  Summary& summary = record.summary();
  summary.dimension = problem.dimension();
  summary.points = problem.point_count();
  summary.sites = problem.site_count();
  summary.seed = options.seed;
  summary.threads_given = options.threads;
  summary.threads_used = arena.threads();
  require_for_ranks();
  summary.initialization_used = warm ? "owners" : name_of(options.initialization);

  {
    const Stop::Pause pause(stop);  // without sites there is no tessellation
    place_sites();
  }
  try {
    const auto pause = pause_for(problem.point_count());
    divide_points();
  } catch (const Stopped&) {
    deal({}, {});
    end(Termination::cancelled);
    return;
  }
  summary.levels = static_cast<int>(levels.size());
  if (!continues()) {
    if (warm) {
      take_owners();
    } else {
      enter_level(0);
    }
    if (is_kept() && dealt.empty()) begin_keeping();
  }
  if (!dealt.empty()) end(Termination::cancelled);
  if (is_kept()) stop.be_patient(kTimeForIteration);
}

/// Fast CCVT [Program 2]: one turn of its loop. With several levels [5.2] the tessellation of one
/// that is stable goes on with the points that join on the next.
template <class Scalar>
bool Run<Scalar>::step() {
  if (record.ended()) return false;
  stop.enter();
  // The first points may have joined without asking: see pause_for().
  const bool unwanted = record.iterations() == 0 && stop.requested();
  if (unwanted || cancelled_together(false)) return end_for_now(Termination::cancelled);
  if (record.iterations() >= options.max_iterations) {
    return end_for_now(Termination::iteration_limit);
  }

  const double energy_before = record.energy();
  const PassCount done = pass();
  const double energy = energy_of_sites();
  const bool wished = record.add(done, static_cast<int>(level), state.cells.point_count(), energy,
                                 progress(done), options);
  const bool go_on = ranks() ? !cancelled_together(!wished) : wished;

  if (done.stopped || (!go_on && !is_kept())) return end(Termination::cancelled);
  if (!go_on_from(energy_before, energy)) return false;
  if (!is_kept()) return true;
  if (!go_on || stop.wished()) return end_for_now(Termination::cancelled);
  keep_if_due();
  return true;
}

/// After a pass: to the next level when this one is at its end. False when the run is.
template <class Scalar>
bool Run<Scalar>::go_on_from(double energy_before, double energy) {
  if (!(descent ? descent->ended() : relaxer->stable())) {
    const bool improved = energy_before - energy >= options.energy_tolerance * energy_before;
    return improved || !on_finest_level() || options.energy_tolerance == 0 ||
           end(Termination::energy_tolerance);
  }
  if (descent) {
    const bool pairs_next = on_finest_level() && descent->depth() != Depth::even;
    descent.reset();
    if (pairs_next) return true;
    if (on_finest_level()) return end(Termination::blue_noise);
  }
  if (on_finest_level()) return end(Termination::stable);
  enter_level(level + 1);
  return dealt.empty() || end(Termination::cancelled);
}

template <class Scalar>
PassCount Run<Scalar>::pass() {
  const auto timed = record.relaxing();
  if (descent) {
    const PassCount done = descent->step(state);
    if (!descent->unsuited()) return done;
    descent.reset();
  }
  return relaxer->step(state);
}

/// How far the run has come: levels count as their points, and a level by how many sites are at
/// rest.
template <class Scalar>
double Run<Scalar>::progress(const PassCount& done) const {
  double before = 0;
  double all = 0;
  std::size_t joined = 0;
  for (std::size_t l = 0; l < levels.size(); ++l) {
    if (l == level) before = all;
    joined += levels[l].joining.size();
    all += static_cast<double>(joined);
  }
  constexpr double kBeforePairs = 0.8;  // of a level that is descended first
  constexpr double kBrief = 0.1;
  const auto descended = [this] {
    if (!on_finest_level() || descent->depth() == Depth::even) return descent->progress();
    return (descent->depth() == Depth::full ? kBeforePairs : kBrief) * descent->progress();
  };
  const double here =
      descent ? descended() : 1 - static_cast<double>(done.active_sites) / problem.site_count();
  return (before + here * static_cast<double>(state.cells.point_count())) / all;
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

/// Ends the run; points of levels that it has not reached join. False.
template <class Scalar>
bool Run<Scalar>::end(Termination termination) {
  const auto cut_short = [this] {
    return stop.late() || late ? Termination::time_limit : Termination::cancelled;
  };
  if (termination == Termination::cancelled) {
    termination = cut_short();
    // Owners as good as the sites, if there is time for that.
    if (ranks() == nullptr) stop.allow(kTimeToFinish);
    if (!on_finest_level() && problem.point_count() > kMostToFinish && ranks() == nullptr) {
      deal(state.cells, state.cells.sizes());
    }
  }
  while (!on_finest_level()) enter_level(level + 1);
  stop.off();
  // Cancelled while points of the last levels joined.
  record.end(dealt.empty() ? termination : cut_short(), problem, box);
  return false;
}

/// Initial sites, in spatial order.
template <class Scalar>
void Run<Scalar>::place_sites() {
  const auto charge = arena.phase(Phase::sites);
  box = bounding_box(problem, arena);
  around = search_box(domain, box);
  coordinate_bound = largest_coordinate(problem, domain, box, arena);
  const SiteState given = initial_sites(problem, metric, options.seed, arena);
  state.tiling = Tiling::of_points(problem.site_count(), problem.point_count(), options.tile_sites);
  site_of = spatial_order(given, state.tiling.sites_per_tile(), arena);
  if (ranks() != nullptr) {
    std::vector<Index> capacities;
    for (const SiteNumber s : site_of) capacities.push_back(problem.capacities()[s]);
    state.tiling.deal(*ranks(), capacities);
  }
  state.sites = SiteState(given.dimension, given.count());
  for (const SiteNumber k : state.sites.all()) {
    std::copy_n(given.at(site_of[k]), given.dimension, state.sites.at(k));
  }
  for (const SiteNumber k : state.sites.all()) {
    if (!given.fixed.empty()) state.sites.fixed.push_back(given.fixed[site_of[k]]);
  }
}

/// The points of each level, and what their sites hold.
template <class Scalar>
void Run<Scalar>::divide_points() {
  const auto charge = arena.phase(Phase::levels);
  std::vector<Index> capacities;
  capacities.reserve(site_of.size());
  for (const SiteNumber given : site_of) capacities.push_back(problem.capacities()[given]);
  levels.resize(1);
  levels[0].capacities = capacities;
  levels = make_levels(capacities, problem.point_count(), options, arena);
  if (ranks() == nullptr) return;
  const auto first = static_cast<std::size_t>(problem.first_own_point());
  for (Level& made : levels) {
    made.joining.keep_own(first, first + static_cast<std::size_t>(problem.points().count));
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

/// Lets the points of the next level join the cells. When the run is cancelled meanwhile, all
/// points are dealt out.
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
  state.cells = {};
  level = next;
  try {
    const auto pause = pause_for(static_cast<std::int64_t>(levels[level].joining.size()));
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
std::unique_ptr<Relaxer<Scalar>> Run<Scalar>::make_relaxer() {
  return std::make_unique<Relaxer<Scalar>>(metric, options, arena, stop, state.sites.count(),
                                           coordinate_bound);
}

/// All points of the level are in cells: the sites move to their centroids.
template <class Scalar>
void Run<Scalar>::begin_level() {
  relaxer = make_relaxer();
  {
    const Stop::Pause pause(stop);
    update_all(metric, state, arena);
  }
  if (const std::optional<Depth> depth = descends()) {
    weights.resize(state.sites.count(), 0.0);
    descent = std::make_unique<Descent<Scalar>>(metric, arena, stop, own_points(), state, *depth,
                                                weights);
  }
  record.begin(energy_of_sites(), on_finest_level());
}

template <class Scalar>
Columns<Scalar> Run<Scalar>::site_columns() const {
  return ccvt::site_columns(problem, metric, state.sites, [&](SiteNumber k) { return site_of[k]; });
}

template <class Scalar>
std::vector<Index> Run<Scalar>::owners() const {
  if (ranks() != nullptr) return owners_at_home();
  std::vector<Index> owners(static_cast<std::size_t>(problem.point_count()), -1);
  const auto given = [&](SiteNumber site) { return site_of[site].index(); };
  const Arena apart(options.threads);  // not the run's: nothing of this belongs to it
  apart.for_each(dealt.size(), kPointsPerGrain,
                 [&](std::size_t p) { owners[p] = given(dealt[p]); });
  if (!dealt.empty()) return owners;
  for_each_site(apart, state.tiling, [&](SiteNumber k) {
    for (const PointOfAll p : state.cells.points(k)) owners[p] = given(k);
  });
  return owners;
}

template struct Run<float>;
template struct Run<double>;

}  // namespace ccvt
