// Sites that stay where they are.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/lloyd.h"
#include "ccvt/metrics.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/generate.h"
#include "support/message.h"
#include "support/oracle.h"
#include "support/same.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

template <class Scalar>
Points<Scalar> places(const Box& box, Index count) {
  return ccvt::sample_uniform<Scalar>(box, count, 5, ccvt::Distribution::white);
}

template <class Scalar>
void check(const Problem<Scalar>& problem, const Options& options = {}) {
  const auto result = ccvt::tessellate(problem, options);
  CHECK(result.summary.termination == Termination::stable);
  CHECK(faults(problem, result) == "");
  const auto fixed = problem.fixed_sites().eigen();
  CHECK(result.sites.leftCols(fixed.cols()) == fixed);
}

double smallest_distance(const Points<double>& sites) {
  return ccvt::nearest_distances({sites, Domain::periodic(Box::unit(2))}).smallest;
}

}  // namespace

TEST_SUITE_BEGIN("fixed sites");

TEST_CASE_TEMPLATE("they stay, and the tessellation is stable around them", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 9}) {
    for (const bool periodic : {false, true}) {
      CAPTURE(dimension);
      CAPTURE(periodic);
      const Box box = uneven_box(dimension);
      const Index sites = 14;
      const auto capacities = unequal_capacities(sites);
      const auto points = make_points<Scalar>(Layout::random, box, sum_of(capacities));
      Problem<Scalar> problem(points, sites);
      problem.set_capacities(capacities);
      if (periodic) problem.set_domain(Domain::periodic(box));
      for (const Index fixed : {1, 5, sites}) {
        CAPTURE(fixed);
        problem.set_fixed_sites(places<Scalar>(box, fixed));
        check(problem, {.seed = 4});
      }
    }
  }
}

TEST_CASE("with every start, swap and selection of pairs") {
  const Box box = uneven_box(2);
  const auto points = make_points<double>(Layout::random, box, 900);
  Problem<double> problem(points, 30);
  problem.set_fixed_sites(places<double>(box, 8));
  for (const auto start : {ccvt::Initialization::balanced, ccvt::Initialization::coherent,
                           ccvt::Initialization::random}) {
    check(problem, {.initialization = start});
  }
  for (const Options& options :
       {Options::balzer2009(), Options::section4(), Options::fast_ccvt()}) {
    check(problem, options);
  }
}

TEST_CASE("with many points a site, by steps of all sites that move") {
  const auto points = make_points<double>(Layout::random, uneven_box(2), 12 * 2500);
  Problem<double> problem(points, 12);
  problem.set_fixed_sites(places<double>(uneven_box(2), 4));
  check(problem);
  const auto pairs = ccvt::tessellate(problem, {.descent_points = 0});
  const auto steps = ccvt::tessellate(problem);
  CHECK(steps.summary.energy < 1.02 * pairs.summary.energy);
  problem.set_fixed_sites(places<double>(uneven_box(2), 12));
  check(problem);
  problem.set_fixed_sites(places<double>(uneven_box(2), 4));
  const auto even = ccvt::tessellate(problem, {.until = ccvt::Until::blue_noise});
  CHECK(ownership_faults(problem, even.owners) == "");
  CHECK(even.sites.leftCols(4) == problem.fixed_sites().eigen());
}

TEST_CASE("far outside, at one place, and where a site was drawn") {
  const auto points = make_points<double>(Layout::random, uneven_box(2), 300);
  Problem<double> problem(points, 10);
  Points<double> fixed(2, 4);
  fixed.col(0) << 1e6, -1e6;
  for (Index s = 1; s < 4; ++s) fixed.col(s) = points.col(17);
  problem.set_fixed_sites(fixed);
  check(problem);
}

TEST_CASE_TEMPLATE("on a torus, in the box with its faces, they come back as given", Scalar, float,
                   double) {
  const Box box = uneven_box(2);
  const auto points = make_points<Scalar>(Layout::random, box, 300);
  Problem<Scalar> problem(points, 10);
  problem.set_domain(Domain::periodic(box, {true, false}));
  Points<Scalar> fixed = places<Scalar>(box, 5);
  fixed(0, 1) = static_cast<Scalar>(box.upper[0]);
  fixed(1, 2) = static_cast<Scalar>(box.upper[1]);
  fixed(0, 3) = static_cast<Scalar>(box.lower[0]);
  problem.set_fixed_sites(fixed);
  check(problem);
  CHECK(ccvt::lloyd(problem).sites.leftCols(5) == fixed);
  fixed(0, 4) = static_cast<Scalar>(box.upper[0] + 1);
  problem.set_fixed_sites(fixed);
  const auto outside = ccvt::tessellate(problem);
  CHECK(outside.sites.col(4)(0) == doctest::Approx(box.lower[0] + 1));
  CHECK(outside.sites.leftCols(4) == fixed.leftCols(4));
}

TEST_CASE_TEMPLATE("on a torus, on faces that have to be rounded, they come back as given", Scalar,
                   float, double) {
  for (const Box& box : {Box{{0, 0}, {.1, .1}}, Box{{.7, -.3}, {1.1, .3}}}) {
    Points<Scalar> points = make_points<Scalar>(Layout::random, Box::unit(2), 300);
    for (int d = 0; d < 2; ++d) {
      const auto lower = static_cast<Scalar>(box.lower[d]);
      const auto upper = static_cast<Scalar>(box.upper[d]);
      points.row(d) = (lower + (upper - lower) * points.row(d).array()).max(lower).min(upper);
    }
    Problem<Scalar> problem(points, 10);
    problem.set_domain(Domain::periodic(box));
    Points<Scalar> fixed(2, 2);
    fixed.col(0) << static_cast<Scalar>(box.upper[0]), static_cast<Scalar>(box.upper[1]);
    fixed.col(1) << static_cast<Scalar>(box.lower[0]), static_cast<Scalar>(box.lower[1]);
    problem.set_fixed_sites(fixed);
    const auto result = ccvt::tessellate(problem);
    CHECK(result.sites.leftCols(2) == fixed);
    CHECK(result.summary.energy ==
          doctest::Approx(ccvt::energy(points, result.sites, result.owners, Domain::periodic(box)))
              .epsilon(1e-4));
    CHECK(ccvt::lloyd(problem).sites.leftCols(2) == fixed);
  }
}

TEST_CASE("beside initial sites and owners") {
  const auto points = make_points<double>(Layout::random, uneven_box(2), 300);
  Problem<double> problem(points, 10);
  const auto free = ccvt::tessellate(problem);
  problem.set_fixed_sites(places<double>(uneven_box(2), 3));
  problem.set_initial_sites(free.sites);
  check(problem);
  problem.set_initial_owners(free.owners);
  check(problem);
}

TEST_CASE("Lloyd's iterations leave them, too") {
  const auto points = make_points<double>(Layout::random, uneven_box(2), 2000);
  Problem<double> problem(points, 20);
  problem.set_fixed_sites(places<double>(uneven_box(2), 6));
  const auto result = ccvt::lloyd(problem, {.max_iterations = 40});
  CHECK(result.sites.leftCols(6) == problem.fixed_sites().eigen());
  std::vector<Points<double>> cells(20, Points<double>::Zero(2, 1));
  std::vector<int> sizes(20, 0);
  double energy = 0;
  for (Index p = 0; p < 2000; ++p) {
    const auto owner = static_cast<std::size_t>(result.owners[static_cast<std::size_t>(p)]);
    cells[owner] += points.col(p);
    ++sizes[owner];
    energy += (points.col(p) - result.sites.col(result.owners[static_cast<std::size_t>(p)]))
                  .squaredNorm();
  }
  CHECK(result.summary.energy == doctest::Approx(energy).epsilon(1e-12));
  for (std::size_t s = 6; s < 20; ++s) {
    const Points<double> centroid = cells[s] / sizes[s];
    CHECK((centroid - result.sites.col(static_cast<Index>(s))).norm() < 1e-12);
  }
}

TEST_CASE("any number of threads gives the same bits") {
  const auto points = ccvt::sample_uniform<float>(Box::unit(2), 300 * 700, 3);
  Problem<float> problem(points, 300);
  problem.set_domain(Domain::periodic(Box::unit(2)));
  problem.set_fixed_sites(places<float>(Box::unit(2), 40));
  for (const auto until : {ccvt::Until::stable, ccvt::Until::blue_noise}) {
    const auto one = ccvt::tessellate(problem, {.threads = 1, .until = until});
    for (const int threads : {2, 3}) {
      CHECK(differences(one, ccvt::tessellate(problem, {.threads = threads, .until = until})) ==
            "");
    }
  }
}

TEST_CASE("samples added to a design that exists keep their distance from it, too") {
  const Box box = Box::unit(2);
  const Domain torus = Domain::periodic(box);
  const auto points = ccvt::sample_uniform<double>(box, 400 * 256, 1);
  Problem<double> problem(points, 400);
  problem.set_domain(torus);
  const auto free = ccvt::tessellate(problem, Options::samples());
  // A fifth of a good design, and the rest added to it: nearly as good as all at once.
  problem.set_fixed_sites(free.sites.leftCols(80));
  const auto added = ccvt::tessellate(problem, Options::samples());
  CHECK(smallest_distance(added.sites) > 0.4);
  CHECK(smallest_distance(free.sites) > 0.6);
  CHECK(added.summary.energy < 1.05 * free.summary.energy);
}

TEST_CASE("what cannot be is refused") {
  const auto points = make_points<double>(Layout::random, uneven_box(2), 20);
  Problem<double> problem(points, 4);
  CHECK(message_of([&] { problem.set_fixed_sites(Points<double>::Zero(2, 5)); }) ==
        "fixed_sites: there are 5 of them, but the problem has 4 sites in all");
  CHECK(message_of([&] { problem.set_fixed_sites(Points<double>::Zero(3, 2)); }) ==
        "fixed_sites: they have 3 dimensions, the points have 2");
  Points<double> bad = Points<double>::Zero(2, 2);
  bad(1, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK(message_of([&] { problem.set_fixed_sites(bad); }).find("fixed_sites") == 0);
}

TEST_SUITE_END();
