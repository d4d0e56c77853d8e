#include "ccvt/solver.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <utility>

#include "normalize.h"
#include "parallel/arena.h"
#include "precision.h"
#include "relax/deal.h"
#include "relax/initial_sites.h"
#include "relax/initialize.h"
#include "relax/levels.h"
#include "relax/relaxer.h"
#include "relax/site_order.h"
#include "relax/update.h"
#include "stopwatch.h"

namespace ccvt {
namespace {

constexpr int kBalancedDimensions = 8;
/// Points of levels that a cancelled run has not reached: with more, kTimeToFinish is not tried.
constexpr Index kMostToFinish = 1 << 24;

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

}  // namespace

template <class Scalar>
struct Solver<Scalar>::Implementation {
  Implementation(Problem<Scalar> given_problem, Options given_options);

  void place_sites();
  void enter_level(std::size_t next);
  void join(std::span<const Index> joining, std::span<const Pair> near, Filling<Scalar>& filling);
  void deal(const Cells<Scalar>& owned, std::span<const Index> filled);
  void make_relaxer();
  void take_owners();
  void record(const PassCount& pass);
  void finish(Termination termination);
  bool step();

  Problem<Scalar> problem;
  Options options;
  Summary summary;
  Stop stop;
  Arena arena;
  Metric metric;
  Box box;
  double coordinate_bound = 0;

  /// The solver numbers sites by where they are: site_of[k] is the caller's number of site k.
  std::vector<Index> site_of;
  std::vector<Level> levels;
  std::size_t level = 0;
  Cells<Scalar> cells;
  SiteState sites;
  std::unique_ptr<Relaxer<Scalar>> relaxer;
  /// Of a run that was cancelled, when there was no time for more: the owners, by deal_rest().
  std::vector<Index> dealt;
};

template <class Scalar>
Solver<Scalar>::Implementation::Implementation(Problem<Scalar> given_problem, Options given_options)
    : problem(std::move(given_problem)),
      options((given_options.validate(), std::move(given_options))),
      stop(options.cancelled),
      arena(options.threads, &stop),
      metric(problem.dimension(), problem.domain()) {
  const Stopwatch total(summary.seconds_total);
  const Stopwatch initialization(summary.seconds_initialization);
  box = problem.bounding_box();
  coordinate_bound =
      std::max(box.lower.eigen().cwiseAbs().maxCoeff(), box.upper.eigen().cwiseAbs().maxCoeff());
  if (options.initialization == Initialization::automatic) {
    options.initialization = problem.dimension() <= kBalancedDimensions ? Initialization::balanced
                                                                        : Initialization::coherent;
  }
  const bool warm = !problem.initial_owners().empty();
  if (warm) options.multilevel = false;

  summary.dimension = problem.dimension();
  summary.points = problem.point_count();
  summary.sites = problem.site_count();
  summary.seed = options.seed;
  summary.threads_given = options.threads;
  summary.threads_used = arena.threads();
  summary.initialization_used = warm ? "owners" : name_of(options.initialization);

  place_sites();
  std::vector<Index> capacities(problem.capacities().size());
  for (std::size_t k = 0; k < capacities.size(); ++k) {
    capacities[k] = problem.capacities()[static_cast<std::size_t>(site_of[k])];
  }
  try {
    levels = make_levels(capacities, problem.point_count(), options, arena);
  } catch (const Stopped&) {
    levels.assign(1, {std::move(capacities), {}});
    summary.levels = 1;
    deal({}, {});
    finish(Termination::cancelled);
    return;
  }
  summary.levels = static_cast<int>(levels.size());
  if (warm) {
    take_owners();
  } else {
    enter_level(0);
  }
  if (!dealt.empty()) finish(Termination::cancelled);
}

/// Initial sites, in spatial order.
template <class Scalar>
void Solver<Scalar>::Implementation::place_sites() {
  const int dimension = problem.dimension();
  const SiteState given = initial_sites(problem, metric, options.seed);
  site_of = spatial_order(given.position, dimension, options.tile_sites);
  sites = SiteState(dimension, given.count());
  for (std::size_t k = 0; k < site_of.size(); ++k) {
    std::copy_n(given.at(site_of[k]), dimension, sites.at(static_cast<Index>(k)));
  }
}

template <class Scalar>
void Solver<Scalar>::Implementation::take_owners() {
  std::vector<Index> rank(site_of.size());
  for (std::size_t k = 0; k < site_of.size(); ++k) {
    rank[static_cast<std::size_t>(site_of[k])] = static_cast<Index>(k);
  }
  cells = Cells<Scalar>(problem.dimension(), levels[0].capacities);
  Filling<Scalar> filling(cells, problem.points());
  for (Index p = 0; p < problem.point_count(); ++p) {
    const Index owner = problem.initial_owners()[static_cast<std::size_t>(p)];
    filling.add(rank[static_cast<std::size_t>(owner)], p);
  }
  levels[0].joining = {};
  make_relaxer();
}

/// Gives the joining points owners by the chosen initialization.
template <class Scalar>
void Solver<Scalar>::Implementation::join(std::span<const Index> joining,
                                          std::span<const Pair> near, Filling<Scalar>& filling) {
  switch (options.initialization) {
    case Initialization::automatic:  // decided by the constructor
    case Initialization::balanced:
      return join_balanced(metric, sites, box, joining, near, arena, filling);
    case Initialization::coherent:
      return join_coherent(metric, sites, joining, options.seed, filling, arena);
    case Initialization::random:
      return join_random(joining, options.seed, filling, arena);
  }
}

/// Lets the points of the next level join the cells. When the run is cancelled meanwhile, all
/// points are dealt out.
template <class Scalar>
void Solver<Scalar>::Implementation::enter_level(std::size_t next) {
  const auto near = relaxer ? relaxer->listed() : std::vector<Pair>{};
  Cells<Scalar> larger(problem.dimension(), levels[next].capacities);
  Filling<Scalar> filling(larger, problem.points());
  for (Index s = 0; level < next && s < cells.site_count(); ++s) {
    filling.add_cell(cells, s);
  }
  cells = {};
  level = next;
  try {
    join(levels[level].joining, near, filling);
  } catch (const Stopped&) {
    return deal(larger, filling.filled);
  } catch (...) {
    deal(larger, filling.filled);
    finish(Termination::cancelled);
    throw;
  }
  levels[level].joining = {};
  cells = std::move(larger);
  make_relaxer();
}

/// Ends a cancelled run: all points get owners without more ado, and the sites stay as they are.
template <class Scalar>
void Solver<Scalar>::Implementation::deal(const Cells<Scalar>& owned,
                                          std::span<const Index> filled) {
  stop.off();
  dealt = deal_rest(metric, sites, box, problem.points(), levels.back().capacities, owned, filled);
  level = levels.size() - 1;
  levels[level].joining = {};
  cells = {};
  relaxer.reset();
  constexpr std::size_t kPart = 1 << 16;
  std::vector<double> parts((dealt.size() + kPart - 1) / kPart, 0.0);
  arena.for_each(parts.size(), 1, [&](std::size_t part) {
    for (std::size_t p = part * kPart; p < std::min((part + 1) * kPart, dealt.size()); ++p) {
      parts[part] +=
          metric.squared_distance(problem.points()[static_cast<Index>(p)], sites.at(dealt[p]));
    }
  });
  summary.energy = std::accumulate(parts.begin(), parts.end(), 0.0);
  summary.initial_energy = summary.energy;
}

template <class Scalar>
void Solver<Scalar>::Implementation::make_relaxer() {
  relaxer = std::make_unique<Relaxer<Scalar>>(metric, options, arena, stop, cells, sites,
                                              coordinate_bound);
  const Stop::Pause pause(stop);
  relaxer->update_all();
  summary.energy = total_energy(sites);
  if (level + 1 == levels.size()) summary.initial_energy = summary.energy;
}

template <class Scalar>
void Solver<Scalar>::Implementation::record(const PassCount& pass) {
  IterationRecord record;
  record.iteration = ++summary.iterations;
  record.level = static_cast<int>(level);
  record.levels = summary.levels;
  record.points = cells.point_count();
  record.full = pass.full;
  record.pairs = pass.pairs;
  record.swaps = pass.swaps;
  record.exchanged = pass.exchanged;
  record.active_sites = pass.active_sites;
  record.energy = total_energy(sites);
  record.seconds = summary.seconds_total;
  summary.pairs += pass.pairs;
  summary.swaps += pass.swaps;
  summary.exchanged += pass.exchanged;
  summary.energy = record.energy;
  summary.iterations_log.push_back(record);
}

template <class Scalar>
void Solver<Scalar>::Implementation::finish(Termination termination) {
  if (termination == Termination::cancelled) {
    // Owners as good as the sites, if there is time for that.
    stop.allow(kTimeToFinish);
    if (level + 1 < levels.size() && problem.point_count() > kMostToFinish) {
      deal(cells, cells.sizes());
    }
  }
  while (level + 1 < levels.size()) {
    const Stopwatch total(summary.seconds_total);
    const Stopwatch initialization(summary.seconds_initialization);
    enter_level(level + 1);
  }
  stop.off();
  // Cancelled while points of the last levels joined.
  summary.termination = dealt.empty() ? termination : Termination::cancelled;
  normalize_energy(box, summary);
  double capacity_error_sum = 0;
  const double n = problem.site_count();
  const double mean = problem.point_count() / n;
  for (const Index c : problem.capacities()) {
    capacity_error_sum += std::pow(c / mean - 1, 2);
  }
  summary.capacity_error = capacity_error_sum / n;
  const double spacing =
      std::min(spacing_in_box(box, summary.points),
               spacing_in_cells(summary.energy, summary.points, summary.sites, summary.dimension));
  const std::string warning = coarse_coordinates<Scalar>("points", problem.points(), spacing);
  if (!warning.empty()) summary.warnings.push_back(warning);
}

template <class Scalar>
bool Solver<Scalar>::Implementation::step() {
  if (summary.termination != Termination::running) return false;
  stop.enter();
  if (summary.iterations >= options.max_iterations) {
    finish(Termination::iteration_limit);
    return false;
  }
  const double energy_before = summary.energy;
  PassCount pass;
  {
    const Stopwatch total(summary.seconds_total);
    const Stopwatch relaxation(summary.seconds_relaxation);
    pass = relaxer->step();
  }
  record(pass);
  const bool finest = level + 1 == levels.size();
  if (pass.stopped ||
      (options.on_iteration && !options.on_iteration(summary.iterations_log.back()))) {
    finish(Termination::cancelled);
  } else if (relaxer->stable()) {
    if (finest) {
      finish(Termination::stable);
    } else {
      const Stopwatch total(summary.seconds_total);
      const Stopwatch initialization(summary.seconds_initialization);
      enter_level(level + 1);
    }
    if (!dealt.empty()) finish(Termination::cancelled);
  } else if (finest && options.energy_tolerance > 0 &&
             energy_before - summary.energy < options.energy_tolerance * energy_before) {
    finish(Termination::energy_tolerance);
  }
  return summary.termination == Termination::running;
}

template <class Scalar>
Solver<Scalar>::Solver(Problem<Scalar> problem, Options options)
    : implementation_(std::make_unique<Implementation>(std::move(problem), std::move(options))) {}

template <class Scalar>
Solver<Scalar>::Solver(Solver&& other) noexcept
    : implementation_(std::move(other.implementation_)) {}
template <class Scalar>
Solver<Scalar>& Solver<Scalar>::operator=(Solver&& other) noexcept {
  implementation_ = std::move(other.implementation_);
  return *this;
}
template <class Scalar>
Solver<Scalar>::~Solver() {}  // NOLINT: where Implementation is complete

template <class Scalar>
bool Solver<Scalar>::step() {
  return implementation_->step();
}

template <class Scalar>
void Solver<Scalar>::run() {
  while (implementation_->step()) {
  }
}

template <class Scalar>
void Solver<Scalar>::cancel() {
  if (implementation_->summary.termination == Termination::running) {
    implementation_->stop.enter();
    implementation_->finish(Termination::cancelled);
  }
}

template <class Scalar>
Columns<Scalar> Solver<Scalar>::site_columns() const {
  const Implementation& i = *implementation_;
  Columns<Scalar> sites(i.problem.dimension(), i.problem.site_count());
  for (Index k = 0; k < i.problem.site_count(); ++k) {
    const double* position = i.sites.at(k);
    for (int d = 0; d < i.problem.dimension(); ++d) {
      sites(d, i.site_of[static_cast<std::size_t>(k)]) =
          i.metric.template as<Scalar>(position[d], d);
    }
  }
  return sites;
}

template <class Scalar>
std::vector<Index> Solver<Scalar>::owners() const {
  const Implementation& i = *implementation_;
  std::vector<Index> owners(static_cast<std::size_t>(i.problem.point_count()), -1);
  for (std::size_t p = 0; p < i.dealt.size(); ++p) {
    owners[p] = i.site_of[static_cast<std::size_t>(i.dealt[p])];
  }
  for (Index k = 0; k < i.cells.site_count(); ++k) {
    const Index* points = i.cells.points(k);
    for (Index p = 0; p < i.cells.size(k); ++p) {
      owners[static_cast<std::size_t>(points[p])] = i.site_of[static_cast<std::size_t>(k)];
    }
  }
  return owners;
}

template <class Scalar>
const Summary& Solver<Scalar>::summary() const {
  return implementation_->summary;
}

// Each member that is compiled here; a whole class would bring along what is inline.
template CCVT_EXPORT Solver<float>::Solver(Problem<float>, Options);
template CCVT_EXPORT Solver<double>::Solver(Problem<double>, Options);
template CCVT_EXPORT Solver<float>::Solver(Solver&&) noexcept;
template CCVT_EXPORT Solver<double>::Solver(Solver&&) noexcept;
template CCVT_EXPORT Solver<float>& Solver<float>::operator=(Solver&&) noexcept;
template CCVT_EXPORT Solver<double>& Solver<double>::operator=(Solver&&) noexcept;
template CCVT_EXPORT Solver<float>::~Solver();
template CCVT_EXPORT Solver<double>::~Solver();
template CCVT_EXPORT bool Solver<float>::step();
template CCVT_EXPORT bool Solver<double>::step();
template CCVT_EXPORT void Solver<float>::run();
template CCVT_EXPORT void Solver<double>::run();
template CCVT_EXPORT void Solver<float>::cancel();
template CCVT_EXPORT void Solver<double>::cancel();
template CCVT_EXPORT Columns<float> Solver<float>::site_columns() const;
template CCVT_EXPORT Columns<double> Solver<double>::site_columns() const;
template CCVT_EXPORT std::vector<Index> Solver<float>::owners() const;
template CCVT_EXPORT std::vector<Index> Solver<double>::owners() const;
template CCVT_EXPORT const Summary& Solver<float>::summary() const;
template CCVT_EXPORT const Summary& Solver<double>::summary() const;

}  // namespace ccvt
