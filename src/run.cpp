#include "run.h"

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <utility>

#include "bounds.h"
#include "descent/descent.h"
#include "parallel/loops.h"
#include "parallel/pages.h"
#include "parallel/together.h"
#include "relax/initial_sites.h"
#include "relax/relaxer.h"
#include "relax/site_columns.h"
#include "relax/site_order.h"
#include "relax/update.h"
#include "run_record.h"

namespace ccvt {
namespace {

/// Points of levels that a cancelled run has not reached: with more, kTimeToFinish is not tried.
constexpr Index kMostToFinish = 1 << 24;
/// What an iteration may take to its end, so that a checkpoint can be left, before a run that is to
/// stop gives it up.
constexpr std::chrono::milliseconds kTimeForIteration{10'000};

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
  const bool begins = begin_or_continue();
  if (begins && is_kept() && dealt.empty()) begin_keeping();
  if (!dealt.empty()) end(Termination::cancelled);
  if (is_kept()) stop.be_patient(kTimeForIteration);
}

/// Up to where all points of the coarsest level have owners, or to where an earlier run had come;
/// whether it begins.
template <class Scalar>
bool Run<Scalar>::begin_or_continue() {
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
  const bool kept = continues();
  try {
    // What was kept is better than any deal of points to the first sites.
    const auto pause = pause_for(kept ? 0 : problem.point_count());
    divide_points();
  } catch (const Stopped&) {
    deal({}, {});
    return false;
  }
  summary.levels = static_cast<int>(levels.size());
  if (kept) {
    take_kept();
    return false;
  }
  if (warm) {
    take_owners();
  } else {
    enter_level(0);
  }
  return true;
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

/// After a pass: to the next level when this one is at its end, or down once more where pairs
/// creep, or where torn cells have been mended on the finest. False when the run is at its end.
template <class Scalar>
bool Run<Scalar>::go_on_from(double energy_before, double energy) {
  if (!(descent ? descent->ended() : relaxer->stable())) {
    const bool improved = energy_before - energy >= options.energy_tolerance * energy_before;
    if (!improved && on_finest_level() && options.energy_tolerance > 0) {
      return end(Termination::energy_tolerance);
    }
    if (!descent && pairs_creep()) descend_again(energy);
    return true;
  }
  if (descent) {
    const bool pairs_next = on_finest_level() && descent->depth() != Depth::even;
    descent.reset();
    leave_to_pairs(energy);
    if (pairs_next) return true;
    if (on_finest_level()) return end(Termination::blue_noise);
  }
  try {
    const bool mended = mend_torn_cells();
    if (on_finest_level()) return mended || end(Termination::stable);
  } catch (const Stopped&) {
    return end(Termination::cancelled);
  }
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
    leave_to_pairs(record.energy());
  }
  const PassCount done = relaxer->step(state);
  if (done.full) turns.passes += double{1} * done.active_sites / problem.site_count();
  return done;
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

template <class Scalar>
Columns<Scalar> Run<Scalar>::site_columns() const {
  return ccvt::site_columns(problem, metric, state.sites, [&](SiteNumber k) { return site_of[k]; });
}

template <class Scalar>
std::vector<Index> Run<Scalar>::owners() const {
  if (ranks() != nullptr) return owners_at_home();
  auto owners = vector_in_large_pages<Index>(static_cast<std::size_t>(problem.point_count()), -1);
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
