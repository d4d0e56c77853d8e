#include "codebook/pairwise.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "codebook/dealing.h"
#include "geometry/coordinate_range.h"

namespace ccvt {
namespace {

/// Extents beyond two to the power of plus or minus this are brought near 1.
constexpr double kModerate = 32;
/// In more dimensions tessellate() would let vectors choose their sites one by one.
constexpr int kMostBalanced = 8;

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
  const auto in_units = [unit](double x) { return static_cast<Scalar>(x * unit); };
  Points<Scalar> scaled;
  if (unit != 1) {
    scaled.resize(vectors.dimension, vectors.count);
    for (Index p = 0; p < vectors.count; ++p) {
      std::transform(vectors[p], vectors[p] + vectors.dimension, scaled.col(p).data(), in_units);
    }
  }
  const auto n = static_cast<Index>(capacities.size());
  Problem<Scalar> problem(unit != 1 ? view_points(scaled) : vectors, n);
  problem.set_capacities(std::move(capacities));
  if (vectors.dimension > kMostBalanced) {
    problem.set_initial_owners(deal_to_nearest(vectors, sites, problem.capacities(), arena));
  } else {
    Points<Scalar> initial(vectors.dimension, n);
    std::transform(sites.begin(), sites.end(), initial.data(), in_units);
    problem.set_initial_sites(initial);
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
