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
template <class Scalar>
double unit_of(PointsView<Scalar> vectors, const Arena& arena) {
  const double widest = box_around(vectors, arena).extent().maxCoeff();
  const double exponent = widest > 0 ? -std::round(std::log2(widest)) : 0;
  return std::abs(exponent) > kModerate ? std::exp2(exponent) : 1;
}

}  // namespace

template <class Scalar>
PairwiseCells pairwise_cells(PointsView<Scalar> vectors, std::span<const double> sites,
                             std::vector<Index> capacities, Options options, const Arena& arena) {
  const double unit = unit_of(vectors, arena);
  Points<Scalar> scaled;
  if (unit != 1) {
    scaled.resize(vectors.dimension, vectors.count);
    for (Index p = 0; p < vectors.count; ++p) {
      std::transform(vectors[p], vectors[p] + vectors.dimension, scaled.col(p).data(),
                     [unit](double x) { return static_cast<Scalar>(x * unit); });
    }
    vectors = view_points(scaled);
  }
  std::vector<double> start(sites.begin(), sites.end());
  for (double& x : start) x *= unit;
  const auto n = static_cast<Index>(capacities.size());
  Problem<Scalar> problem(vectors, n);
  problem.set_capacities(std::move(capacities));
  if (vectors.dimension > kBalancedDimensions) {
    // tessellate() would let vectors choose their sites one by one.
    problem.set_initial_owners(deal_to_nearest(vectors, start, problem.capacities(), arena));
  } else {
    problem.set_initial_sites(Eigen::Map<const Points<double>>(start.data(), vectors.dimension, n)
                                  .template cast<Scalar>());
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

template PairwiseCells pairwise_cells(PointsView<float>, std::span<const double>,
                                      std::vector<Index>, Options, const Arena&);
template PairwiseCells pairwise_cells(PointsView<double>, std::span<const double>,
                                      std::vector<Index>, Options, const Arena&);

}  // namespace ccvt
