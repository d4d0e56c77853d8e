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

/// Of the progress of a run in two turns.
constexpr double kProgressOfFirst = 0.5;

/// What has been done of a run in several parts.
struct Done {
  double seconds = 0;
  double progress = 0;
  bool cancelled = false;
};

/// The options of its next part, of which `share` of the whole is told.
Options part_after(const Done& done, double share, Options options) {
  if (options.time_limit > 0) {
    options.time_limit = std::max(options.time_limit - done.seconds, 1e-3);
  }
  if (done.cancelled) {
    options.cancelled = [] { return true; };
    options.on_iteration = nullptr;
  } else if (options.on_iteration) {
    options.on_iteration = [report = std::move(options.on_iteration), done,
                            share](IterationRecord record) {
      record.seconds += done.seconds;
      record.progress = done.progress + share * record.progress;
      return report(record);
    };
  }
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
  Done done;
  for (const Share& share : shares) {
    const PointsView<Scalar> own{view[share.first], view.dimension, share.points, view.stride};
    const double of_first = kProgressOfFirst * share.points / view.count;
    const auto [centroids, owned, summary] =
        tessellate_line(own, share.sites, part_after(done, of_first, first));
    const auto before = static_cast<Index>(capacities.size());
    for (const Index owner : owned) owners.push_back(before + owner);
    const std::vector<Index> equal = equal_capacities(share.points, share.sites);
    capacities.insert(capacities.end(), equal.begin(), equal.end());
    done.seconds += summary.seconds_total;
    done.progress += of_first;
    done.cancelled = done.cancelled || summary.termination == Termination::cancelled;
  }
  points.template bottomRows<3>() *= static_cast<Scalar>(shrink);
  Problem<Scalar> problem(points, sites, options.threads);
  problem.set_capacities(std::move(capacities));
  problem.set_initial_owners(std::move(owners));
  Result<Scalar> result = tessellate(problem, part_after(done, 1 - done.progress, options));
  result.summary.seconds_total += done.seconds;
  return {std::move(result.sites), std::move(result.owners), std::move(result.summary)};
}

template Outcome<float> tessellate_in_turns(Points<float>&, std::span<const Index>, Index, double,
                                            const Options&);
template Outcome<double> tessellate_in_turns(Points<double>&, std::span<const Index>, Index, double,
                                             const Options&);

}  // namespace ccvt
