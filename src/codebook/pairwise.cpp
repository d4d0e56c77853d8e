#include "codebook/pairwise.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "codebook/dealing.h"
#include "geometry/coordinate_range.h"
#include "run.h"

namespace ccvt {
namespace {

/// Extents beyond two to the power of plus or minus this are brought near 1.
constexpr double kModerate = 32;

/// The power of two to multiply vectors with so that their squares have all their digits.
double unit_of(const Box& vectors) {
  const double widest = vectors.extent().maxCoeff();
  const double exponent = widest > 0 ? -std::round(std::log2(widest)) : 0;
  return std::abs(exponent) > kModerate ? std::exp2(exponent) : 1;
}

/// The points times `unit`.
template <class Scalar>
Points<Scalar> scaled(PointsView<Scalar> points, double unit) {
  Points<Scalar> in_units(points.dimension, points.count);
  for (Index p = 0; p < points.count; ++p) {
    std::transform(points[p], points[p] + points.dimension, in_units.col(p).data(),
                   [unit](double x) { return static_cast<Scalar>(x * unit); });
  }
  return in_units;
}

/// Moves sites outside of the box to its faces.
void bring_into(const Box& box, std::vector<double>& sites) {
  for (std::size_t k = 0; k < sites.size(); ++k) {
    const auto d = static_cast<Eigen::Index>(k) % box.dimension();
    sites[k] = std::clamp(sites[k], box.lower[d], box.upper[d]);
  }
}

}  // namespace

template <class Scalar>
PairwiseCells pairwise_cells(const Vectors<Scalar>& vectors, PointsView<Scalar> all,
                             std::vector<double>& sites, std::vector<Index> capacities,
                             Options options, const Arena& arena) {
  const Box box = box_around(all, arena);
  bring_into(box, sites);
  const double unit = unit_of(box);
  Points<Scalar> in_units;
  if (unit != 1) {
    in_units = scaled(all, unit);
    all = view_points(in_units);
  }
  std::vector<double> start(sites.begin(), sites.end());
  for (double& x : start) x *= unit;
  const auto n = static_cast<Index>(capacities.size());
  const auto [ranks, first, count] = vectors.own();
  const PointsView<Scalar> own{all[first], all.dimension, count, all.stride};
  Problem<Scalar> problem = ranks == nullptr ? Problem<Scalar>(own, n, options.threads)
                                             : Problem<Scalar>(*ranks, own, n, options.threads);
  problem.set_capacities(std::move(capacities));
  if (all.dimension > kBalancedDimensions) {
    // tessellate() would let vectors choose their sites one by one.
    const std::vector<Index> owners = deal_to_nearest(all, start, problem.capacities(), arena);
    const auto begin = owners.begin() + first;
    problem.set_initial_owners(std::vector<Index>(begin, begin + own.count));
  } else {
    problem.set_initial_sites(
        Eigen::Map<const Points<double>>(start.data(), all.dimension, n).template cast<Scalar>());
  }
  if (options.on_iteration) {
    options.on_iteration = [unit,
                            report = std::move(options.on_iteration)](IterationRecord record) {
      record.energy /= unit * unit;
      return report(record);
    };
  }
  auto result = tessellate(problem, options);
  return {std::move(result.owners), result.summary.termination};
}

template PairwiseCells pairwise_cells(const Vectors<float>&, PointsView<float>,
                                      std::vector<double>&, std::vector<Index>, Options,
                                      const Arena&);
template PairwiseCells pairwise_cells(const Vectors<double>&, PointsView<double>,
                                      std::vector<double>&, std::vector<Index>, Options,
                                      const Arena&);

}  // namespace ccvt
