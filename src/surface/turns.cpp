#include "surface/turns.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "ccvt/capacity.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "numbers.h"
#include "surface/shares.h"

namespace ccvt {

namespace {

/// Where the first turn ends.
constexpr double kFirstTolerance = 1e-3;

/// The options for what is left of the time.
Options after(double seconds, Options options) {
  if (options.time_limit > 0) options.time_limit = std::max(options.time_limit - seconds, 1e-3);
  return options;
}

/// Cells of equal capacities. Sites start in the middle of stretches of the line that are as large
/// as their cells.
template <class Scalar>
Outcome<Scalar> tessellate_line(PointsView<Scalar> points, Index sites, const Options& options) {
  const std::vector<Index> capacities = equal_capacities(points.count, sites);
  Points<Scalar> start(points.dimension, sites);
  Index begin = 0;
  for (const SiteNumber s : sites_below(sites)) {
    std::copy_n(points[begin + capacities[s] / 2], points.dimension, start.col(s.index()).data());
    begin += capacities[s];
  }
  Problem<Scalar> problem(points, sites, options.threads);
  problem.set_initial_sites(start);
  Result<Scalar> result = tessellate(problem, options);
  return {std::move(result.sites), std::move(result.owners), std::move(result.summary)};
}

}  // namespace

template <class Scalar>
Outcome<Scalar> tessellate_in_turns(Points<Scalar>& points, std::span<const Index> groups,
                                    Index sites, double shrink, const Options& options) {
  const PointsView<Scalar> view = view_points(points);
  if (points.rows() == 3) return tessellate_line(view, sites, options);
  const std::vector<Share> shares = share_sites(groups, sites);
  if (shares.size() == 1 && shrink == 1) return tessellate_line(view, sites, options);

  Options first = options;
  first.energy_tolerance = std::max(first.energy_tolerance, kFirstTolerance);
  std::vector<Index> owners;
  owners.reserve(groups.size());
  std::vector<Index> capacities;
  double seconds = 0;
  for (const Share& share : shares) {
    const PointsView<Scalar> own{view[share.first], view.dimension, share.points, view.stride};
    const auto [centroids, owned, summary] =
        tessellate_line(own, share.sites, after(seconds, first));
    const auto before = static_cast<Index>(capacities.size());
    for (const Index owner : owned) owners.push_back(before + owner);
    const std::vector<Index> equal = equal_capacities(share.points, share.sites);
    capacities.insert(capacities.end(), equal.begin(), equal.end());
    seconds += summary.seconds_total;
  }
  points.template bottomRows<3>() *= static_cast<Scalar>(shrink);
  Problem<Scalar> problem(points, sites, options.threads);
  problem.set_capacities(std::move(capacities));
  problem.set_initial_owners(std::move(owners));
  Result<Scalar> result = tessellate(problem, after(seconds, options));
  result.summary.seconds_total += seconds;
  return {std::move(result.sites), std::move(result.owners), std::move(result.summary)};
}

template Outcome<float> tessellate_in_turns(Points<float>&, std::span<const Index>, Index, double,
                                            const Options&);
template Outcome<double> tessellate_in_turns(Points<double>&, std::span<const Index>, Index, double,
                                             const Options&);

}  // namespace ccvt
