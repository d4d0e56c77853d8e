#include "ccvt/thin.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "checks.h"
#include "geometry/chosen_points.h"
#include "geometry/metric.h"
#include "no_checkpoint.h"
#include "normalize.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/loops.h"
#include "relax/site_order.h"
#include "relax/site_state.h"
#include "scales.h"
#include "thin/homes.h"
#include "thin/lift.h"
#include "thin/owners.h"
#include "thin/repulsion.h"
#include "thin/sides.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = std::size_t{1} << 14;
constexpr Index kSitesPerTile = 64;
/// Seconds in which points may get owners when the time is over.
constexpr double kLeastTime = 0.01;

void count(Thinning& result) {
  result.counts.assign(result.chosen.size(), 0);
  for (const Index owner : result.owners) ++result.counts[SiteNumber(owner)];
}

bool was_stopped(const Thinning& result) {
  return result.summary.termination == Termination::cancelled ||
         result.summary.termination == Termination::time_limit;
}

/// One run of thin(): sites have the numbers of the tessellation until they are sorted.
template <class Scalar>
class Thinner {
 public:
  using Clock = std::chrono::steady_clock;

  /// `points`: as they are tessellated, with normals if there are any. `start`: of all of thin().
  Thinner(PointsView<Scalar> points, Index sites, const ThinOptions& options, Stop& stop,
          const Arena& arena, Clock::time_point start)
      : points_(points),
        sites_(sites),
        options_(options),
        stop_(stop),
        arena_(arena),
        metric_(points.dimension, Domain()),
        start_(start) {}

  void tessellate(Thinning& result);
  void spread(Thinning& result);
  void make_cells(bool lifted, Thinning& result);
  [[nodiscard]] double seconds() const {
    return std::chrono::duration<double>(Clock::now() - start_).count();
  }

 private:
  [[nodiscard]] Options options_now() const;
  void end_stopped(Thinning& result) const {
    result.summary.termination = stop_.late() ? Termination::time_limit : Termination::cancelled;
  }
  void number_by_place(Thinning& result);
  void make_cells(const Side& side, Thinning& result);
  void choose_nearest(PointsView<Scalar> centres, Thinning& result) const;
  [[nodiscard]] std::vector<Place> places_of(const Homes<Scalar>& homes,
                                             const std::vector<Index>& chosen) const;

  PointsView<Scalar> points_;
  Index sites_;
  const ThinOptions& options_;
  Stop& stop_;
  const Arena& arena_;
  Metric metric_;
  Points<Scalar> centres_;
  Clock::time_point start_;
};

/// The options of a solver, for the time that is left.
template <class Scalar>
Options Thinner<Scalar>::options_now() const {
  Options options = options_.tessellation;
  if (options.time_limit > 0) {
    options.time_limit = std::max(options.time_limit - seconds(), kLeastTime);
  }
  return options;
}

/// The first choice: in each cell of equal capacity the point nearest to its centroid.
template <class Scalar>
void Thinner<Scalar>::tessellate(Thinning& result) {
  const int threads = options_.tessellation.threads;
  Solver<Scalar> solver(Problem<Scalar>(points_, sites_, threads), options_now());
  solver.run();
  result.owners = solver.owners();
  result.summary = solver.summary();
  centres_ = solver.sites();
  choose_nearest(view_points(centres_), result);
}

/// Of several, the first.
template <class Scalar>
void Thinner<Scalar>::choose_nearest(PointsView<Scalar> centres, Thinning& result) const {
  const auto count = static_cast<std::size_t>(sites_);
  std::vector<double> least(count, std::numeric_limits<double>::infinity());
  result.chosen.assign(count, -1);
  for (const PointNumber p : points_below(points_.count)) {
    const SiteNumber s(result.owners[p]);
    const double squared = metric_.squared_distance(points_[p.index()], centres[s.index()]);
    if (!(squared < least[s])) continue;
    least[s] = squared;
    result.chosen[s] = p.index();
  }
}

template <class Scalar>
std::vector<Place> Thinner<Scalar>::places_of(const Homes<Scalar>& homes,
                                              const std::vector<Index>& chosen) const {
  std::vector<Place> places;
  places.reserve(chosen.size());
  for (const SiteNumber s : sites_below(chosen.size())) {
    const auto own = homes.points[s];  // ascending
    const auto at = std::lower_bound(own.begin(), own.end(), PointNumber(chosen[s]));
    places.emplace_back(homes.points.first[s] + static_cast<std::size_t>(at - own.begin()));
  }
  return places;
}

/// Gives sites numbers that are near each other where they are: what is looked up together then
/// lies together.
template <class Scalar>
void Thinner<Scalar>::number_by_place(Thinning& result) {
  SiteState sites(points_.dimension, sites_);
  for (const SiteNumber s : sites.all()) {
    std::copy_n(centres_.col(s.index()).data(), points_.dimension, sites.at(s));
  }
  const std::vector<SiteNumber> old = spatial_order(sites, kSitesPerTile, arena_);
  const Points<Scalar> centres = centres_;
  const std::vector<Index> chosen = result.chosen;
  std::vector<Index> rank(old.size());
  for (const SiteNumber s : sites.all()) {
    rank[old[s]] = s.index();
    centres_.col(s.index()) = centres.col(old[s].index());
    result.chosen[s] = chosen[old[s]];
  }
  for (Index& owner : result.owners) owner = rank[SiteNumber(owner)];
  count(result);
}

/// Moves the chosen points apart.
template <class Scalar>
void Thinner<Scalar>::spread(Thinning& result) {
  try {
    number_by_place(result);
    const Homes<Scalar> homes =
        make_homes(metric_, points_, result.owners, view_points(centres_), arena_);
    Repulsion<Scalar> repulsion(homes, places_of(homes, result.chosen), arena_);
    const bool whole = repulsion.run();
    result.moves = repulsion.moves();
    result.jumps = repulsion.jumps();
    std::transform(repulsion.chosen().begin(), repulsion.chosen().end(), result.chosen.begin(),
                   [&](Place place) { return homes.point(place).index(); });
    if (!whole) throw Stopped();
  } catch (const Stopped&) {
    end_stopped(result);
  }
}

/// Gives all points but the chosen ones owners anew, who stay where they are. With normals each
/// side is divided by itself, if there is time.
template <class Scalar>
void Thinner<Scalar>::make_cells(bool lifted, Thinning& result) {
  const std::vector<Index> counts = result.counts;
  std::vector<Side> sides;
  try {
    if (lifted && !was_stopped(result)) sides = sides_of(points_, result.chosen, arena_);
  } catch (const Stopped&) {
    end_stopped(result);
  }
  if (sides.size() > 1) {
    for (const Side& side : sides) {
      // As even as can be, those with one more among the others.
      const auto until = [&](std::size_t k) { return k * side.points.size() / side.sites.size(); };
      for (std::size_t k = 0; k < side.sites.size(); ++k) {
        result.counts[SiteNumber(side.sites[k])] = static_cast<Index>(until(k + 1) - until(k));
      }
      make_cells(side, result);
      if (was_stopped(result)) break;
    }
    if (!was_stopped(result)) return;
  }
  result.counts = counts;
  Side all{std::vector<Index>(result.owners.size()), std::vector<Index>(result.chosen.size())};
  std::iota(all.points.begin(), all.points.end(), 0);
  std::iota(all.sites.begin(), all.sites.end(), 0);
  make_cells(all, result);
}

/// As result.counts says of the sites.
template <class Scalar>
void Thinner<Scalar>::make_cells(const Side& side, Thinning& result) {
  std::vector<Index> sites;  // that own others
  std::vector<Index> at;
  std::vector<Index> capacities;
  std::vector<Index> chosen;
  for (const Index s : side.sites) {
    chosen.push_back(result.chosen[SiteNumber(s)]);
    result.owners[PointNumber(chosen.back())] = s;
    if (result.counts[SiteNumber(s)] == 1) continue;
    sites.push_back(s);
    at.push_back(chosen.back());
    capacities.push_back(result.counts[SiteNumber(s)] - 1);
  }
  std::sort(chosen.begin(), chosen.end());
  std::vector<Index> others;
  std::set_difference(side.points.begin(), side.points.end(), chosen.begin(), chosen.end(),
                      std::back_inserter(others));
  if (others.empty()) return;
  const Points<Scalar> points = chosen_points(points_, others);
  Options options = options_now();
  options.on_iteration = nullptr;
  Problem<Scalar> problem(points, static_cast<Index>(sites.size()), options.threads);
  problem.set_capacities(std::move(capacities)).set_fixed_sites(chosen_points(points_, at));
  Solver<Scalar> solver(std::move(problem), options);
  solver.run();
  const std::vector<Index> owners = solver.owners();
  for (std::size_t k = 0; k < others.size(); ++k) {
    result.owners[PointNumber(others[k])] = sites[SiteNumber(owners[PointNumber(k)])];
  }
  const Termination ended = solver.summary().termination;
  if (ended == Termination::cancelled || ended == Termination::time_limit) {
    result.summary.termination = ended;
  }
}

/// Gives sites their numbers in the order of the points chosen.
void sort(Thinning& result) {
  std::vector<SiteNumber> order;
  for (const SiteNumber s : sites_below(result.chosen.size())) order.push_back(s);
  std::sort(order.begin(), order.end(),
            [&](SiteNumber a, SiteNumber b) { return result.chosen[a] < result.chosen[b]; });
  std::vector<Index> rank(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) rank[order[k]] = SiteNumber(k).index();
  std::sort(result.chosen.begin(), result.chosen.end());
  for (Index& owner : result.owners) owner = rank[SiteNumber(owner)];
}

/// How many of these points lie where another one does that comes before.
template <class Scalar>
std::size_t copies_among(PointsView<Scalar> points, std::vector<Index> numbers) {
  const auto coordinates = [&](Index p) {
    return std::span(points[p], static_cast<std::size_t>(points.dimension));
  };
  std::sort(numbers.begin(), numbers.end(), [&](Index a, Index b) {
    return std::ranges::lexicographical_compare(coordinates(a), coordinates(b));
  });
  std::size_t copies = 0;
  for (std::size_t k = 1; k < numbers.size(); ++k) {
    copies += std::ranges::equal(coordinates(numbers[k - 1]), coordinates(numbers[k])) ? 1 : 0;
  }
  return copies;
}

template <class Scalar>
double energy_of(PointsView<Scalar> points, const Thinning& result, const Arena& arena) {
  const Metric metric(points.dimension, Domain());
  return sum_of(arena, result.owners.size(), kPointsPerGrain, [&](std::size_t k) {
    const Index chosen = result.chosen[SiteNumber(result.owners[k])];
    return metric.squared_distance(points[PointNumber(k).index()], points[chosen]);
  });
}

/// Points count for the nearest chosen one, but each of those for itself, and not for chosen points
/// that they face away from. Leaves owners that are valid when stopped.
template <class Scalar>
void finish_owners(PointsView<Scalar> space, bool nearest, bool lifted, const Arena& arena,
                   Thinning& result) {
  for (const SiteNumber s : sites_below(result.chosen.size())) {
    result.owners[PointNumber(result.chosen[s])] = s.index();
  }
  try {
    if (nearest) result.owners = nearest_chosen(space, result.chosen, arena);
    if (lifted) result.turned = take_turned(space, result.chosen, result.owners, arena);
  } catch (const Stopped&) {
    result.summary.termination = Termination::cancelled;
  }
}

/// Throws unless normals of that length are coordinates that can be reckoned with.
template <class Scalar>
void require_length(double length, double weight, double spacing, int dimension) {
  const double largest = largest_coordinate<Scalar>(dimension);
  if (length <= largest) return;
  throw InvalidInput(concat("normal_weight: is ", weight, ", for points that are ", spacing,
                            " apart; the product must be at most ", largest));
}

}  // namespace

void ThinOptions::validate() const {
  if (!(normal_weight >= 0 && normal_weight <= 100)) {
    throw InvalidInput(concat("normal_weight: is ", normal_weight, "; must be from 0 to 100"));
  }
  tessellation.validate();
  require_no_checkpoint(tessellation, "thin()");
}

template <class Scalar>
Thinning thin(PointsView<Scalar> points, Index sites, const ThinOptions& options,
              PointsView<Scalar> normals) {
  const auto start = Thinner<Scalar>::Clock::now();
  options.validate();
  const bool has_normals = normals.count > 0 || normals.dimension > 0;
  if (has_normals && (normals.count != points.count || normals.dimension != points.dimension)) {
    throw InvalidInput(concat("normals: there are ", normals.count, " of ", normals.dimension,
                              " dimensions, for ", points.count, " points of ", points.dimension,
                              "; needs one a point, of as many dimensions"));
  }
  require_data("normals", normals);
  const int threads = options.tessellation.threads;
  static_cast<void>(Problem<Scalar>(points, sites, threads));  // checks them
  Thinning result;
  Stop stop(options.tessellation.cancelled, options.tessellation.time_limit);
  const Arena untold(threads);
  result.spacing = typical_spacing(points, sites, options.tessellation.seed, untold);
  const double length = has_normals ? options.normal_weight * result.spacing : 0;
  const bool lifts = length > 0;
  require_length<Scalar>(length, options.normal_weight, result.spacing, 2 * points.dimension);
  const Points<Scalar> lifted = lifts ? lift(points, normals, length, untold) : Points<Scalar>();
  const PointsView<Scalar> space = lifts ? view_points(lifted) : points;

  const Arena arena(threads, &stop);
  Thinner<Scalar> thinner(space, sites, options, stop, arena, start);
  thinner.tessellate(result);
  count(result);
  if (options.spread && !was_stopped(result) && sites > 1 && sites < points.count) {
    thinner.spread(result);
  }
  const bool moved = result.moves + result.jumps > 0;
  if (options.equal_counts && (moved || (lifts && !was_stopped(result)))) {
    thinner.make_cells(lifts, result);
  }
  Stop cancel(options.tessellation.cancelled);  // not for the time: owners are as asked for then
  finish_owners(space, !options.equal_counts, lifts, Arena(threads, &cancel), result);
  sort(result);
  count(result);
  result.energy = energy_of(points, result, untold);
  count_normals(space.dimension - points.dimension, result.summary);
  if (const std::size_t copies = copies_among(points, result.chosen); copies > 0) {
    result.summary.warnings.push_back(concat(copies, " of the ", sites,
                                             " points chosen lie where another",
                                             " one does: many points are in the same places"));
  }
  result.summary.seconds_total = thinner.seconds();
  return result;
}

template CCVT_EXPORT Thinning thin(PointsView<float>, Index, const ThinOptions&, PointsView<float>);
template CCVT_EXPORT Thinning thin(PointsView<double>, Index, const ThinOptions&,
                                   PointsView<double>);

}  // namespace ccvt
