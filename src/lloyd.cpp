#include "ccvt/lloyd.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "bounds.h"
#include "ccvt/capacity.h"
#include "cell_sizes.h"
#include "no_checkpoint.h"
#include "normalize.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "parallel/loops.h"
#include "relax/cells.h"
#include "relax/initial_sites.h"
#include "relax/moving_cells.h"
#include "relax/nearest_sites.h"
#include "relax/owner_bounds.h"
#include "relax/site_columns.h"
#include "relax/update.h"
#include "schedule/tiling.h"
#include "settling_progress.h"
#include "stopwatch.h"

namespace ccvt {
namespace {

/// After so many iterations cells are gathered anew, as their radii have grown.
constexpr int kIterationsApart = 32;
constexpr std::size_t kPointsPerGrain = 4096;

/// Termination. As for PairSwapper: a point changes its owner only when that gains more than the
/// rounding of the two distances and `margin_`, the sum over cells of size * e^2, where e bounds
/// the distance between a site and the exact centroid that it was rounded from. So the energy
/// around exact centroids falls with each iteration that changes an owner, and no assignment
/// returns. Ties never move a point.
template <class Scalar>
class Lloyd {
 public:
  Lloyd(const Problem<Scalar>& problem, const Options& options);
  detail::LloydResult<Scalar> run();

 private:
  void start();
  bool step();
  void assign_first();
  void assign_all();
  Buffer<OwnerChange> changes();
  Buffer<OwnerChange> changes_of_all();
  Index assign();
  void gather();
  void update();
  void bound_margin();
  void finish(Termination termination);

  const Problem<Scalar>& problem_;
  const Options& options_;
  Stop stop_;
  Arena arena_;
  Domain domain_;  ///< in which distances are measured
  Metric metric_;
  Box box_;     ///< of the points
  Box around_;  ///< where sites are looked for
  double coordinate_bound_;
  SiteState sites_;
  std::vector<Index> owners_;
  OwnerBounds<Scalar> bounds_;
  MovingCells cells_;
  int gathered_ = 0;                   ///< iterations since
  std::vector<std::uint8_t> changed_;  ///< of each site: whether its cell has changed
  double margin_ = 0;
  Summary summary_;
  SettlingProgress progress_;
};

template <class Scalar>
Lloyd<Scalar>::Lloyd(const Problem<Scalar>& problem, const Options& options)
    : problem_((require_sites(problem), problem)),
      options_((options.validate(), options)),
      stop_(options.cancelled, options.time_limit),
      arena_(options.threads, &stop_),
      domain_(measured_domain(problem)),
      metric_(problem.dimension(), domain_),
      box_(problem.bounding_box()),
      around_(search_box(domain_, box_)),
      coordinate_bound_(largest_coordinate(problem, domain_, box_, Arena(options.threads))),
      bounds_(metric_, problem.points(), arena_),
      cells_(metric_) {
  summary_.dimension = problem.dimension();
  summary_.points = problem.point_count();
  summary_.sites = problem.site_count();
  summary_.seed = options.seed;
  summary_.threads_given = options.threads;
  summary_.threads_used = arena_.threads();
}

/// The first owners, and the centroids of their cells.
template <class Scalar>
void Lloyd<Scalar>::start() {
  const Stopwatch total(summary_.seconds_total);
  const Stopwatch initialization(summary_.seconds_initialization);
  progress_.begin(1);
  {
    const Stop::Pause pause(stop_);  // without sites there is no tessellation
    sites_ = initial_sites(problem_, metric_, options_.seed, arena_);
  }
  owners_ = problem_.initial_owners();
  changed_.assign(sites_.count(), 1);
  if (owners_.empty()) {
    summary_.initialization_used = "nearest";
    owners_.assign(static_cast<std::size_t>(problem_.point_count()), -1);
    assign_first();
  } else {
    summary_.initialization_used = "owners";
  }
  gather();
  summary_.initial_energy = summary_.energy;
}

/// When the run is cancelled meanwhile and there is no time for all points, these are dealt out
/// evenly in their order.
template <class Scalar>
void Lloyd<Scalar>::assign_first() {
  try {
    assign_all();
    return;
  } catch (const Stopped&) {
    summary_.termination = Termination::cancelled;
  }
  stop_.allow(kTimeToFinish);
  try {
    assign_all();
  } catch (const Stopped&) {
    summary_.warnings.emplace_back(
        "the run ended before points had found their nearest sites: they were dealt out in their "
        "order");
    for (std::size_t p = 0; p < owners_.size(); ++p) {
      owners_[p] = static_cast<Index>(p * changed_.size() / owners_.size());
    }
  }
  stop_.off();
}

/// Gives every point to its nearest site [eq. 3].
template <class Scalar>
void Lloyd<Scalar>::assign_all() {
  const Buffer<SiteNumber> nearest =
      NearestSites<Scalar>(metric_, sites_, around_, arena_).owners(problem_.points(), arena_);
  arena_.for_each(owners_.size(), kPointsPerGrain,
                  [&](std::size_t p) { owners_[p] = nearest[p].index(); });
}

/// The points whose nearest site is another than before, beyond the margin and rounding.
template <class Scalar>
Buffer<OwnerChange> Lloyd<Scalar>::changes() {
  const bool pays = OwnerBounds<Scalar>::pays(problem_.points().count, problem_.site_count(),
                                              problem_.dimension());
  return pays ? bounds_.changes(sites_, owners_, margin_) : changes_of_all();
}
template <class Scalar>
Buffer<OwnerChange> Lloyd<Scalar>::changes_of_all() {
  const Buffer<SiteNumber> nearest =
      NearestSites<Scalar>(metric_, sites_, around_, arena_).owners(problem_.points(), arena_);
  const auto gains = [&](PointNumber point) {
    const Scalar* const x = problem_.points()[point.index()];
    const double own = metric_.squared_distance(x, sites_.at(SiteNumber(owners_[point])));
    const double other = metric_.squared_distance(x, sites_.at(nearest[point]));
    return own - other > rounding_of_difference(metric_, std::sqrt(own)) + margin_;
  };
  return collect<OwnerChange>(
      arena_, owners_.size(), kPointsPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<OwnerChange>& out, int) {
        for (std::size_t p = begin; p < end; ++p) {
          const PointNumber point(p);
          if (nearest[p] != SiteNumber(owners_[p]) && gains(point))
            out.push_back({point, nearest[p]});
        }
      });
}

/// Gives the points whose nearest site is another than before to that [eq. 3]; returns how many.
template <class Scalar>
Index Lloyd<Scalar>::assign() {
  const Buffer<OwnerChange> all = changes();
  for (const auto& [point, to] : all) {
    const SiteNumber from(owners_[point]);
    changed_[from] = changed_[to] = 1;
    owners_[point] = to.index();
    const Scalar* const x = problem_.points()[point.index()];
    cells_.leave(from, x);
    cells_.join(sites_, to, x);
  }
  return static_cast<Index>(all.size());
}

/// Moves the sites of changed cells to their centroids [eq. 2].
template <class Scalar>
void Lloyd<Scalar>::update() {
  bool worn = ++gathered_ >= kIterationsApart;
  for (const SiteNumber s : sites_.all()) worn = worn || cells_.worn(sites_, s);
  if (worn) return gather();
  for (const SiteNumber s : sites_.all()) {
    if (changed_[s] != 0) cells_.update(sites_, s);
  }
  bound_margin();
}

/// The same, from all points.
template <class Scalar>
void Lloyd<Scalar>::gather() {
  const Stop::Pause pause(stop_);
  const auto by_owner = group_by_key<PointNumber>(
      arena_, owners_.size(), sites_.count(), [](std::size_t p) { return PointNumber(p); },
      [&](PointNumber p) { return SiteNumber(owners_[p]); });
  const std::vector<Index> sizes = cell_sizes(owners_, sites_.count());
  Cells<Scalar> cells(metric_.dimension(), sizes);
  const std::size_t sites_per_grain = 1 + kPointsPerGrain * sizes.size() / owners_.size();
  for_each_site(arena_, sizes.size(), sites_per_grain, [&](SiteNumber s) {
    if (sizes[s] > 0) {
      const std::span<const PointNumber> own = by_owner[s];
      for (std::size_t k = 0; k < own.size(); ++k) {
        cells.put(s, static_cast<Index>(k), PointOfAll(own[k].index()),
                  problem_.points()[own[k].index()]);
      }
      sites_.radius[s] = std::numeric_limits<double>::infinity();
      update_site(metric_, cells, sites_, s);
    } else {
      sites_.radius[s] = sites_.energy[s] = 0;
    }
  });
  cells_.take(sites_, sizes);
  gathered_ = 0;
  bound_margin();
}

template <class Scalar>
void Lloyd<Scalar>::bound_margin() {
  constexpr double kRounded = 2;  // where the cell was gathered, and where it has followed points
  margin_ = 0;
  for (const SiteNumber s : sites_.all()) {
    margin_ += energy_of_rounding(metric_, coordinate_bound_, cells_.count(s), sites_.radius[s]);
  }
  margin_ *= kRounded * kRounded;
  summary_.energy = total_energy(sites_, arena_);
}

template <class Scalar>
void Lloyd<Scalar>::finish(Termination termination) {
  summary_.termination =
      termination == Termination::cancelled && stop_.late() ? Termination::time_limit : termination;
  summary_.capacity_error = capacity_error(owners_, summary_.sites);
  normalize_energy(box_, summary_);
}

/// One iteration. False when the run has ended.
template <class Scalar>
bool Lloyd<Scalar>::step() {
  if (summary_.iterations >= options_.max_iterations) {
    finish(Termination::iteration_limit);
    return false;
  }
  if (stop_.requested()) {
    finish(Termination::cancelled);
    return false;
  }
  const double energy_before = summary_.energy;
  IterationRecord record;
  {
    const Stopwatch total(summary_.seconds_total);
    const Stopwatch relaxation(summary_.seconds_relaxation);
    std::fill(changed_.begin(), changed_.end(), std::uint8_t{0});
    try {
      record.exchanged = assign();
    } catch (const Stopped&) {
      finish(Termination::cancelled);
      return false;
    }
    if (record.exchanged > 0) update();
  }
  record.iteration = ++summary_.iterations;
  record.points = summary_.points;
  record.active_sites = std::accumulate(changed_.begin(), changed_.end(), Index{0});
  record.energy = summary_.energy;
  record.seconds = summary_.seconds_total;
  record.progress = progress_.moved(record.exchanged);
  summary_.exchanged += record.exchanged;
  summary_.iterations_log.push_back(record);
  if (options_.on_iteration && !options_.on_iteration(record)) {
    finish(Termination::cancelled);
  } else if (record.exchanged == 0) {
    finish(Termination::stable);
  } else if (options_.energy_tolerance > 0 &&
             energy_before - summary_.energy < options_.energy_tolerance * energy_before) {
    finish(Termination::energy_tolerance);
  }
  return summary_.termination == Termination::running;
}

template <class Scalar>
detail::LloydResult<Scalar> Lloyd<Scalar>::run() {
  start();
  if (summary_.termination == Termination::cancelled) finish(Termination::cancelled);
  while (summary_.termination == Termination::running && step()) {
  }
  detail::LloydResult<Scalar> result;
  result.sites = site_columns(problem_, metric_, sites_, [](SiteNumber s) { return s; });
  result.owners = std::move(owners_);
  result.summary = std::move(summary_);
  return result;
}

}  // namespace

template <class Scalar>
detail::LloydResult<Scalar> detail::lloyd(const Problem<Scalar>& problem, const Options& options) {
  require_no_checkpoint(options, "lloyd()");
  if (problem.ranks() != nullptr) {
    throw InvalidInput("problem: is one of several ranks, which lloyd() does not know");
  }
  return Lloyd<Scalar>(problem, options).run();
}

template CCVT_EXPORT detail::LloydResult<float> detail::lloyd(const Problem<float>&,
                                                              const Options&);
template CCVT_EXPORT detail::LloydResult<double> detail::lloyd(const Problem<double>&,
                                                               const Options&);

}  // namespace ccvt
