#include "ccvt/weighted.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <utility>

#include "bounds.h"
#include "ccvt/metrics.h"
#include "ccvt/solver.h"
#include "geometry/chosen_points.h"
#include "number_text.h"
#include "point_count.h"
#include "relax/site_columns.h"
#include "relax/update.h"
#include "weighted/curve_order.h"
#include "weighted/inputs.h"
#include "weighted/shares.h"
#include "weighted/units.h"
#include "weighted/whole.h"

namespace ccvt {
namespace {

/// Of the progress of a run of whole points, what the unit points are.
constexpr double kProgressOfUnits = 0.6;
/// Until::blue_noise ends when a sweep lowers the energy by less than this share of it.
constexpr double kLittle = 1e-4;

template <class Scalar>
class MassRun {
 public:
  MassRun(PointsView<Scalar> points, std::span<const double> masses, Index sites,
          const MassOptions& options);
  MassResult<Scalar> run();

 private:
  void draw_units();
  void tessellate_units();
  Options unit_options();
  void share();
  void own_whole();
  bool sweep(WholePoints<Scalar>& whole);
  void take_sites(const SiteState& sites, std::vector<double>&& masses, double energy);
  void own_massless(const SiteState& sites);
  void weigh();
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  [[nodiscard]] bool is_whole() const { return options_.method == MassMethod::whole; }
  void end(Termination termination);

  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  const MassOptions& options_;
  Problem<Scalar> problem_;  ///< the points, checked
  Index unit_count_;
  MassInputs inputs_;
  Stop stop_;
  Arena arena_;
  Domain domain_;  ///< in which distances are measured
  Metric metric_;
  Box box_;                         ///< of the points
  Box around_;                      ///< where sites are looked for
  std::vector<PointNumber> units_;  ///< the point of each
  std::vector<Index> unit_owners_;
  SiteState sites_;
  MassResult<Scalar> result_;
};

template <class Scalar>
Problem<Scalar> checked(PointsView<Scalar> points, const MassOptions& options) {
  options.validate();
  Problem<Scalar> problem(points, 1, options.relaxation.threads);
  problem.set_domain(options.domain);
  return problem;
}

template <class Scalar>
MassRun<Scalar>::MassRun(PointsView<Scalar> points, std::span<const double> masses, Index sites,
                         const MassOptions& options)
    : options_(options),
      problem_(checked(points, options)),
      unit_count_(checked_point_count(sites, options.points_per_site)),
      inputs_(masses, static_cast<std::size_t>(points.count), sites, options),
      stop_(options.relaxation.cancelled, options.relaxation.time_limit),
      arena_(options.relaxation.threads, &stop_),
      domain_(measured_domain(problem_)),
      metric_(points.dimension, domain_),
      box_(bounding_box(problem_, arena_)),
      around_(search_box(domain_, box_)) {}

/// A unit point at each part of the mass along a curve through the points.
template <class Scalar>
void MassRun<Scalar>::draw_units() {
  std::vector<PointNumber> order;
  for (const PointNumber p : points_below(inputs_.masses.size())) {
    if (inputs_.masses[p] > 0) order.push_back(p);
  }
  order = curve_order(problem_.points(), std::move(order), arena_);
  units_ = units_along(order, inputs_.masses, inputs_.total, unit_count_, options_.relaxation.seed);
}

/// The caller's, but for what is told of them: energies are of masses, and there is more to come.
template <class Scalar>
Options MassRun<Scalar>::unit_options() {
  Options options = options_.relaxation;
  if (options.cancelled || options.time_limit > 0) {
    options.cancelled = [this] { return stop_.requested(); };
  }
  options.time_limit = 0;
  if (!options.on_iteration) return options;
  const double unit = inputs_.total / inputs_.scale / unit_count_;
  const int more = is_whole() ? 1 : 0;
  options.on_iteration = [report = std::move(options.on_iteration), unit,
                          more](IterationRecord record) {
    record.energy *= unit;
    record.levels += more;
    if (more > 0) record.progress *= kProgressOfUnits;
    return report(record);
  };
  return options;
}

template <class Scalar>
void MassRun<Scalar>::tessellate_units() {
  const Points<Scalar> positions = chosen_points(problem_.points(), units_);
  Problem<Scalar> problem(view_points(positions), static_cast<Index>(inputs_.capacities.size()),
                          options_.relaxation.threads);
  problem.set_domain(options_.domain);
  problem.set_capacities(capacities_in_units(inputs_.capacities, unit_count_));
  Solver<Scalar> solver(std::move(problem), unit_options());
  solver.run();
  unit_owners_ = solver.owners();
  result_.summary = solver.summary();
  const Points<Scalar> sites = solver.sites();
  sites_ = SiteState(sites.rows(), sites.cols());
  std::copy_n(sites.data(), sites.size(), sites_.position.begin());
  Summary& summary = result_.summary;
  if (summary.termination == Termination::cancelled && stop_.late()) end(Termination::time_limit);
  const double unit = inputs_.total / inputs_.scale / unit_count_;
  summary.initial_energy *= unit;
  summary.energy *= unit;
  for (IterationRecord& record : summary.iterations_log) record.energy *= unit;
}

template <class Scalar>
void MassRun<Scalar>::end(Termination termination) {
  result_.summary.termination = termination;
}

/// What the sites are and own, in the caller's units.
template <class Scalar>
void MassRun<Scalar>::take_sites(const SiteState& sites, std::vector<double>&& masses,
                                 double energy) {
  result_.sites = site_columns<Scalar>(metric_, sites, [](SiteNumber s) { return s; });
  result_.masses = std::move(masses);
  for (double& mass : result_.masses) mass /= inputs_.scale;
  result_.summary.energy = energy / inputs_.scale;
}

/// The resampled method: masses are divided as unit points are.
template <class Scalar>
void MassRun<Scalar>::share() {
  const Stop::Pause pause(stop_);
  result_.owners = owners_of_most(units_, unit_owners_, inputs_.masses.size());
  own_by_nearest(metric_, problem_.points(), around_, sites_, arena_, result_.owners);
  result_.shares = shares_of(units_, unit_owners_, result_.owners, inputs_.masses);
  std::vector<double> masses =
      move_to_shares(metric_, problem_.points(), result_.shares, arena_, sites_);
  take_sites(sites_, std::move(masses), total_energy(sites_, arena_));
  own_massless(sites_);
  for (std::size_t k = 0; k < result_.shares.size(); ++k) {
    MassShare& share = result_.shares[k];
    share.mass /= inputs_.scale;
    const bool first = k == 0 || result_.shares[k - 1].point != share.point;
    const bool more = k + 1 < result_.shares.size() && result_.shares[k + 1].point == share.point;
    if (first && more) ++result_.shared_points;
  }
}

/// One sweep. False when the run has ended.
template <class Scalar>
bool MassRun<Scalar>::sweep(WholePoints<Scalar>& whole) {
  Summary& summary = result_.summary;
  const Options& options = options_.relaxation;
  if (summary.iterations >= options.max_iterations) {
    end(Termination::iteration_limit);
    return false;
  }
  const double before = summary.energy;
  const auto done = whole.sweep();
  summary.energy = done.energy / inputs_.scale;
  summary.pairs += done.pairs;
  summary.swaps += done.swaps;
  summary.exchanged += done.exchanged;
  IterationRecord record;
  record.iteration = ++summary.iterations;
  record.level = summary.levels - 1;
  record.levels = summary.levels;
  record.points = summary.points;
  record.pairs = done.pairs;
  record.swaps = done.swaps;
  record.exchanged = done.exchanged;
  record.active_sites = done.changed;
  record.energy = summary.energy;
  record.seconds = seconds();
  const double last = summary.iterations_log.empty() ? 0 : summary.iterations_log.back().progress;
  const double resting = 1 - static_cast<double>(done.changed) / summary.sites;
  record.progress = std::max(last, kProgressOfUnits + (1 - kProgressOfUnits) * resting);
  summary.iterations_log.push_back(record);
  const bool cancelled =
      (options.on_iteration && !options.on_iteration(record)) || done.stopped || stop_.requested();
  const double gained = before - summary.energy;
  const bool many =
      options.descent_points > 0 && summary.points / summary.sites >= options.descent_points;
  if (cancelled) {
    end(stop_.late() ? Termination::time_limit : Termination::cancelled);
  } else if (done.swaps == 0) {
    end(Termination::stable);
  } else if (options.until == Until::blue_noise && many && gained < kLittle * before) {
    end(Termination::blue_noise);
  } else if (options.energy_tolerance > 0 && gained < options.energy_tolerance * before) {
    end(Termination::energy_tolerance);
  }
  return summary.termination == Termination::running;
}

/// The whole method: from the owners of most unit points.
template <class Scalar>
void MassRun<Scalar>::own_whole() {
  Summary& summary = result_.summary;
  const auto cells = [&] {
    const Stop::Pause pause(stop_);
    std::vector<Index> owners = owners_of_most(units_, unit_owners_, inputs_.masses.size());
    own_by_nearest(metric_, problem_.points(), around_, sites_, arena_, owners);
    return MassCells<Scalar>(metric_, problem_.points(), inputs_.masses, inputs_.capacities, owners,
                             sites_, largest_coordinate(problem_, domain_, box_, arena_), arena_);
  };
  MassCells<Scalar> owned = cells();
  units_ = {};
  unit_owners_ = {};
  WholePoints<Scalar> whole(owned, arena_, stop_);
  whole.balance();
  summary.initial_energy = summary.energy = whole.energy() / inputs_.scale;
  summary.levels += 1;
  for (IterationRecord& record : summary.iterations_log) {
    record.levels = summary.levels;
    record.progress *= kProgressOfUnits;
  }
  const bool goes_on = summary.termination != Termination::cancelled &&
                       summary.termination != Termination::time_limit &&
                       summary.termination != Termination::iteration_limit;
  if (goes_on) {
    end(Termination::running);
    while (sweep(whole)) {
    }
  }
  const Stop::Pause pause(stop_);
  std::vector<double> masses(owned.site_count());
  for (const SiteNumber s : owned.sites().all()) masses[s] = owned.held(s);
  take_sites(owned.sites(), std::move(masses), whole.energy());
  result_.owners = owned.owners();
  own_massless(owned.sites());
}

/// Gives points without mass to the nearest site.
template <class Scalar>
void MassRun<Scalar>::own_massless(const SiteState& sites) {
  for (std::size_t p = 0; p < inputs_.masses.size(); ++p) {
    if (!(inputs_.masses[p] > 0)) result_.owners[p] = -1;
  }
  own_by_nearest(metric_, problem_.points(), around_, sites, arena_, result_.owners);
}

/// How far masses are from capacities.
template <class Scalar>
void MassRun<Scalar>::weigh() {
  result_.capacities = inputs_.capacities;
  result_.total_mass = inputs_.total / inputs_.scale;
  Summary& summary = result_.summary;
  const double mean = result_.total_mass / summary.sites;
  double squares = 0;
  summary.capacity_error = 0;
  for (std::size_t s = 0; s < result_.masses.size(); ++s) {
    result_.capacities[s] /= inputs_.scale;
    const double error = std::abs(result_.masses[s] - result_.capacities[s]);
    const double relative = error / result_.capacities[s];
    const double to_mean = result_.masses[s] / mean - 1;
    squares += relative * relative;
    summary.capacity_error += to_mean * to_mean / summary.sites;
    if (error <= result_.largest_mass_error) continue;
    result_.largest_mass_error = error;
    result_.worst_site = static_cast<Index>(s);
  }
  result_.relative_mass_error = std::sqrt(squares / summary.sites);
  result_.mass_error_bound =
      is_whole() ? *std::max_element(inputs_.masses.begin(), inputs_.masses.end()) / inputs_.scale
                 : std::numeric_limits<double>::infinity();
  summary.normalized_energy = 0;
  if (!(box_.extent().minCoeff() > 0)) return;
  const double energy =
      normalized_energy(summary.energy / result_.total_mass, 1, summary.sites, box_);
  if (std::isfinite(energy)) summary.normalized_energy = energy;
}

template <class Scalar>
MassResult<Scalar> MassRun<Scalar>::run() {
  draw_units();
  tessellate_units();
  Summary& summary = result_.summary;
  summary.points = problem_.point_count();
  const double before = seconds();
  if (is_whole()) {
    own_whole();
  } else {
    share();
  }
  weigh();
  const double all = seconds();
  PhaseRecord phase;
  phase.name = "masses";
  phase.seconds = all - before;
  summary.phases.push_back(phase);
  summary.seconds_initialization += before - summary.seconds_total;
  summary.seconds_relaxation += all - before;
  summary.seconds_total = all;
  return std::move(result_);
}

}  // namespace

const char* to_string(MassMethod method) {
  switch (method) {
    case MassMethod::whole:
      return "whole";
    case MassMethod::resampled:
      return "resampled";
  }
  return "unknown";
}

void MassOptions::validate() const {
  if (points_per_site < 1) {
    throw InvalidInput("MassOptions::points_per_site is " + std::to_string(points_per_site) +
                       ": it must be 1 or more");
  }
  relaxation.validate();
}

template <class Scalar>
std::string MassResult<Scalar>::brief_error() const {
  double largest = 0;
  double bound = 0;
  for (std::size_t s = 0; s < masses.size(); ++s) {
    const double relative = std::abs(masses[s] - capacities[s]) / capacities[s];
    if (s > 0 && relative <= largest) continue;
    largest = relative;
    bound = mass_error_bound / capacities[s];
  }
  const auto percent = [](double share) { return text(100 * share, 3) + " %"; };
  return "largest mass error " + percent(largest) + " of its cell's capacity" +
         (std::isfinite(bound) ? ", bound " + percent(bound) : "");
}

template <class Scalar>
MassResult<Scalar> tessellate_masses(PointsView<Scalar> points, std::span<const double> masses,
                                     Index sites, const MassOptions& options) {
  try {
    return MassRun<Scalar>(points, masses, sites, options).run();
  } catch (const Stopped&) {  // before there is anything
    throw Cancelled();
  }
}

template CCVT_EXPORT std::string MassResult<float>::brief_error() const;
template CCVT_EXPORT std::string MassResult<double>::brief_error() const;
template CCVT_EXPORT MassResult<float> tessellate_masses(PointsView<float>, std::span<const double>,
                                                         Index, const MassOptions&);
template CCVT_EXPORT MassResult<double> tessellate_masses(PointsView<double>,
                                                          std::span<const double>, Index,
                                                          const MassOptions&);

}  // namespace ccvt
