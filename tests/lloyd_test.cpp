// lloyd() against its definition, written anew in long double: see support/oracle.h.
#include "ccvt/lloyd.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "support/generate.h"
#include "support/oracle.h"
#include "support/same.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::lloyd;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Result;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

/// What rounding the sites to Scalar can do to a squared distance.
template <class Scalar>
Real rounding(const Problem<Scalar>& problem) {
  const Box box = problem.bounding_box();
  const Real largest =
      std::max(box.lower.eigen().cwiseAbs().maxCoeff(), box.upper.eigen().cwiseAbs().maxCoeff());
  const Real extent = box.extent().norm();
  const Real epsilon = std::numeric_limits<Scalar>::epsilon();
  return 4 * problem.dimension() * epsilon * largest * (extent + largest);
}

/// Empty if every owner is the nearest site: all points, all sites.
template <class Scalar>
std::string nearest_faults(const Problem<Scalar>& problem, const Result<Scalar>& result) {
  const int dimension = problem.dimension();
  for (Index p = 0; p < problem.point_count(); ++p) {
    const Scalar* x = problem.points()[p];
    Real nearest = std::numeric_limits<Real>::infinity();
    for (Index s = 0; s < problem.site_count(); ++s) {
      nearest = std::min(
          nearest, squared_distance(problem.domain(), dimension, x, result.sites.col(s).data()));
    }
    const Index owner = result.owners[static_cast<std::size_t>(p)];
    const Real own =
        squared_distance(problem.domain(), dimension, x, result.sites.col(owner).data());
    if (own > nearest + rounding(problem)) return "point " + std::to_string(p);
  }
  return "";
}

/// Empty if every site that owns points is the mean of their images nearest to it, and the energy
/// is that of the owners.
template <class Scalar>
std::string centroid_faults(const Problem<Scalar>& problem, const Result<Scalar>& result) {
  const int dimension = problem.dimension();
  const auto width = static_cast<std::size_t>(dimension);
  std::vector<std::vector<Real>> sum(static_cast<std::size_t>(problem.site_count()),
                                     std::vector<Real>(width + 1, 0));
  Real energy = 0;
  for (Index p = 0; p < problem.point_count(); ++p) {
    const Index owner = result.owners[static_cast<std::size_t>(p)];
    auto& own = sum[static_cast<std::size_t>(owner)];
    for (int d = 0; d < dimension; ++d) {
      const Real u = wrapped(
          problem.domain(),
          static_cast<Real>(problem.points()[p][d]) - static_cast<Real>(result.sites(d, owner)), d);
      own[static_cast<std::size_t>(d)] += u;
      energy += u * u;
    }
    own[width] += 1;
  }
  std::string wrong;
  const Real allowed = std::sqrt(rounding(problem) * std::numeric_limits<Scalar>::epsilon()) * 8;
  for (std::size_t s = 0; s < sum.size(); ++s) {
    for (std::size_t d = 0; d < width; ++d) {
      if (sum[s][width] > 0 && std::abs(sum[s][d] / sum[s][width]) > allowed) {
        wrong += "site " + std::to_string(s) + " ";
      }
    }
  }
  const Real slack = rounding(problem) * problem.point_count();
  if (std::abs(energy - result.summary.energy) > slack) wrong += "energy ";
  return wrong;
}

template <class Scalar>
std::string descent_faults_of(const Result<Scalar>& result) {
  double before = result.summary.initial_energy;
  for (const auto& record : result.summary.iterations_log) {
    if (record.energy > before * (1 + 1e-12)) {
      return "iteration " + std::to_string(record.iteration);
    }
    before = record.energy;
  }
  return "";
}

template <class Scalar>
void check(const Problem<Scalar>& problem, const Options& options = {}) {
  const Result<Scalar> result = lloyd(problem, options);
  CHECK(result.summary.termination == Termination::stable);
  CHECK(result.owners.size() == static_cast<std::size_t>(problem.point_count()));
  CHECK(nearest_faults(problem, result) == "");
  CHECK(centroid_faults(problem, result) == "");
  CHECK(descent_faults_of(result) == "");
  CHECK(result.summary.capacity_error == ccvt::capacity_error(result.owners, problem.site_count()));
}

}  // namespace

TEST_SUITE_BEGIN("lloyd");

TEST_CASE_TEMPLATE("owners are nearest and sites are centroids", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 5, 17}) {
    for (const bool periodic : {false, true}) {
      const Box box = uneven_box(dimension);
      for (const Layout layout : all_layouts) {
        const auto points = make_points<Scalar>(layout, box, 900);
        for (const Index sites : {40, 18, 9}) {
          CAPTURE(dimension);
          CAPTURE(periodic);
          CAPTURE(name_of(layout));
          CAPTURE(sites);
          Problem<Scalar> problem(points, sites);
          if (periodic) problem.set_domain(Domain::periodic(box));
          check(problem, {.seed = 5});
        }
      }
    }
  }
}

TEST_CASE("the first iteration is the one of the definition") {
  // Six points on a line, sites at 0 and 10: 4 is nearer to 0; then the centroids move.
  Points<double> points(1, 6);
  points << 0, 1, 4, 9, 10, 11;
  Points<double> sites(1, 2);
  sites << 0, 10;
  Problem<double> problem(points, 2);
  problem.set_initial_sites(sites);
  const auto start = lloyd(problem, {.max_iterations = 0});
  CHECK(start.summary.termination == Termination::iteration_limit);
  CHECK(start.owners == std::vector<Index>{0, 0, 0, 1, 1, 1});
  CHECK(start.sites(0, 0) == doctest::Approx(5.0 / 3));
  CHECK(start.sites(0, 1) == doctest::Approx(10.0));
  const auto end = lloyd(problem);
  CHECK(end.summary.termination == Termination::stable);
  CHECK(end.summary.iterations == 1);
  CHECK(end.summary.exchanged == 0);
  CHECK(end.summary.initialization_used == "nearest");
  CHECK(end.summary.capacity_error == 0);
}

TEST_CASE("capacities become unequal, and the summary says how much") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 3000);
  const auto free = lloyd(points, 60);
  const auto constrained = ccvt::tessellate(points, 60);
  CHECK(free.summary.capacity_error > 0.01);
  CHECK(constrained.summary.capacity_error == 0);
  CHECK(free.summary.energy < constrained.summary.energy);
}

TEST_CASE("a site without points stays where it is") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 200);
  Points<double> sites(2, 3);
  sites << 0.2, 0.8, 40, 0.5, 0.5, 40;
  Problem<double> problem(points, 3);
  problem.set_initial_sites(sites);
  const auto result = lloyd(problem);
  CHECK(result.summary.termination == Termination::stable);
  CHECK(result.sites.col(2) == sites.col(2));
  CHECK(std::count(result.owners.begin(), result.owners.end(), 2) == 0);
  CHECK(nearest_faults(problem, result) == "");
}

TEST_CASE("a warm start goes on from the owners given") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 2000);
  Problem<float> problem(points, 50);
  const auto balanced = ccvt::tessellate(problem);
  problem.set_initial_owners(balanced.owners);
  const auto result = lloyd(problem);
  CHECK(result.summary.initialization_used == "owners");
  CHECK(result.summary.initial_energy == doctest::Approx(balanced.summary.energy).epsilon(1e-9));
  CHECK(result.summary.energy < balanced.summary.energy);
  CHECK(nearest_faults(problem, result) == "");
}

TEST_CASE_TEMPLATE("no number of threads changes a bit", Scalar, float, double) {
  for (const int dimension : {2, 3}) {
    const Box box = uneven_box(dimension);
    const auto points = make_points<Scalar>(Layout::random, box, 20000);
    Problem<Scalar> problem(points, 150);
    problem.set_domain(Domain::periodic(box));
    const auto one = lloyd(problem, {.threads = 1, .max_iterations = 10});
    for (const int threads : {2, 3, 8}) {
      const auto many = lloyd(problem, {.threads = threads, .max_iterations = 10});
      CHECK(differences(one, many) == "");
    }
  }
}

TEST_CASE("it ends when told to") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 5000);
  CHECK(lloyd(points, 100, {.max_iterations = 3}).summary.iterations == 3);
  const auto tolerant = lloyd(points, 100, {.energy_tolerance = 0.01});
  CHECK(tolerant.summary.termination == Termination::energy_tolerance);
  int calls = 0;
  const auto told = lloyd(points, 100, {.on_iteration = [&](const ccvt::IterationRecord& record) {
                            CHECK(record.iteration == ++calls);
                            return calls < 2;
                          }});
  CHECK(told.summary.termination == Termination::cancelled);
  CHECK(told.summary.iterations == 2);
  const auto asked = lloyd(points, 100, {.cancelled = [] { return true; }});
  CHECK(asked.summary.termination == Termination::cancelled);
  CHECK(asked.summary.iterations == 0);
  for (const auto& result : {told, asked, tolerant}) {
    CHECK(centroid_faults(Problem<float>(points, 100), result) == "");
  }
  const auto whole = lloyd(points, 100);
  const auto& log = whole.summary.iterations_log;
  CHECK(std::is_sorted(log.begin(), log.end(),
                       [](const auto& a, const auto& b) { return a.progress < b.progress; }));
  CHECK(log.back().progress == 1);
  CHECK(log[log.size() / 2].progress > 0);
  CHECK(log[log.size() / 2].progress < 1);
  CHECK_THROWS_AS(lloyd(points, 100, {.max_iterations = -1}), ccvt::InvalidInput);
}

TEST_SUITE_END();
