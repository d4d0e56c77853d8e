// What must not change, or change in a known way, when the problem or the machine does.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "ccvt/solver.h"
#include "random.h"
#include "support/generate.h"
#include "support/oracle.h"
#include "support/same.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Random;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

template <class Scalar>
Problem<Scalar> make_problem(const Points<Scalar>& points, Index sites, const Box& box,
                             bool periodic) {
  Problem<Scalar> problem(points, sites);
  if (periodic) problem.set_domain(Domain::periodic(box));
  return problem;
}

template <class Scalar>
void check_threads(Layout layout, int dimension, Index sites, Index each, bool periodic,
                   Options options) {
  const Box box = uneven_box(dimension);
  const auto points = make_points<Scalar>(layout, box, sites * each + 3);
  const auto problem = make_problem(points, sites, box, periodic);
  options.threads = 1;
  const auto one = ccvt::tessellate(problem, options);
  CHECK(one.summary.threads_used == 1);
  for (const int threads : {2, 3, 8}) {
    CAPTURE(dimension);
    CAPTURE(threads);
    options.threads = threads;
    const auto many = ccvt::tessellate(problem, options);
    CHECK(many.summary.threads_given == threads);
    CHECK(many.summary.threads_used >= 1);
    CHECK(many.summary.threads_used <= threads);
    CHECK(differences(one, many) == "");
  }
}

template <class Scalar>
void check_scaling(int dimension, bool periodic, const Options& options) {
  const Box box = uneven_box(dimension);
  for (const Layout layout : {Layout::random, Layout::grid, Layout::clusters}) {
    const auto points = make_points<Scalar>(layout, box, 1500);
    const auto problem = make_problem(points, 60, box, periodic);
    const auto plain = ccvt::tessellate(problem, options);
    for (const double scale : {0x1p-20, 0.5, 0x1p13}) {
      CAPTURE(dimension);
      CAPTURE(periodic);
      CAPTURE(name_of(layout));
      CAPTURE(scale);
      const Points<Scalar> scaled_points = points * static_cast<Scalar>(scale);
      const Box scaled_box{box.lower.eigen() * scale, box.upper.eigen() * scale};
      const auto scaled_problem = make_problem(scaled_points, 60, scaled_box, periodic);
      auto scaled = ccvt::tessellate(scaled_problem, options);
      scaled.sites /= static_cast<Scalar>(scale);
      scaled.summary.energy /= scale * scale;
      CHECK(differences(plain, scaled) == "");
      CHECK(scaled.summary.normalized_energy ==
            doctest::Approx(plain.summary.normalized_energy).epsilon(1e-12));
    }
  }
}

}  // namespace

TEST_SUITE_BEGIN("metamorphic");

TEST_CASE_TEMPLATE("any number of threads gives the same bytes", Scalar, float, double) {
  check_threads<Scalar>(Layout::random, 2, 500, 33, false, {});
  check_threads<Scalar>(Layout::grid, 2, 500, 17, true, {});
  check_threads<Scalar>(Layout::random, 2, 500, 17, false, {.cached_passes = 5, .tile_sites = 1});
  check_threads<Scalar>(Layout::clusters, 3, 300, 20, false, {});
  check_threads<Scalar>(Layout::random, 3, 300, 20, true, {.multilevel = false});
  check_threads<Scalar>(Layout::random, 16, 150, 20, false, {});
  check_threads<Scalar>(Layout::random, 16, 150, 20, false,
                        {.multilevel = false, .cached_passes = 3});
  check_threads<Scalar>(Layout::random, 5, 100, 20, true, {});
  check_threads<Scalar>(Layout::random, 2, 150, 20, false, Options::balzer2009());
  check_threads<Scalar>(Layout::random, 2, 300, 20, true, Options::fast_ccvt());
}

TEST_CASE("the same call gives the same bytes, another seed another tessellation") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 4000);
  const auto a = ccvt::tessellate(points, 60, {.seed = 5});
  const auto b = ccvt::tessellate(points, 60, {.seed = 5});
  const auto c = ccvt::tessellate(points, 60, {.seed = 6});
  CHECK(differences(a, b) == "");
  CHECK(a.owners != c.owners);
  CHECK(a.summary.seed == 5);
}

TEST_CASE_TEMPLATE("a power of two scales the sites, its square the energy", Scalar, float,
                   double) {
  for (const int dimension : {1, 2, 3, 9}) check_scaling<Scalar>(dimension, false, {});
  for (const int dimension : {1, 2, 3}) check_scaling<Scalar>(dimension, true, {});
  check_scaling<Scalar>(2, false, Options::fast_ccvt());
  check_scaling<Scalar>(2, true, Options::fast_ccvt());
}

// Enough sites for the energies of two runs from unrelated starts to differ by some tenths of a
// percent only.
constexpr Index many_sites = 1000;
constexpr Index many_points = 32 * many_sites;

TEST_CASE_TEMPLATE("translation keeps the energy", Scalar, float, double) {
  const Box box = Box::unit(2);
  const auto points = make_points<Scalar>(Layout::random, box, many_points);
  const auto plain = ccvt::tessellate(points, many_sites);
  for (const double x : {1.0, -3.7, 100.1}) {
    Points<Scalar> moved = points;
    moved.row(0).array() += static_cast<Scalar>(x);
    moved.row(1).array() -= static_cast<Scalar>(2 * x);
    const Problem<Scalar> problem(moved, many_sites);
    const auto result = ccvt::tessellate(problem);
    CHECK(result.summary.termination == Termination::stable);
    CHECK(ownership_faults(problem, result.owners) == "");
    CHECK(result.summary.energy == doctest::Approx(plain.summary.energy).epsilon(0.01));
  }
}

TEST_CASE_TEMPLATE("so does a shift on the torus", Scalar, float, double) {
  const Box box = uneven_box(2);
  const auto points = make_points<Scalar>(Layout::random, box, many_points);
  const auto plain = ccvt::tessellate(make_problem(points, many_sites, box, true));
  for (const double shift : {0.5, 0.123}) {
    Points<Scalar> moved = points;
    for (Index p = 0; p < many_points; ++p) {
      for (int d = 0; d < 2; ++d) {
        const double extent = box.upper[d] - box.lower[d];
        double x = static_cast<double>(points(d, p)) + shift * extent;
        if (x >= box.upper[d]) x -= extent;
        moved(d, p) = static_cast<Scalar>(std::clamp(x, box.lower[d], box.upper[d]));
      }
    }
    const auto problem = make_problem(moved, many_sites, box, true);
    const auto result = ccvt::tessellate(problem);
    CHECK(result.summary.termination == Termination::stable);
    CHECK(ownership_faults(problem, result.owners) == "");
    CHECK(result.summary.energy == doctest::Approx(plain.summary.energy).epsilon(0.01));
  }
}

// The library starts from points with random numbers, so this is an unrelated start, too.
TEST_CASE_TEMPLATE("so does renumbering", Scalar, float, double) {
  for (const bool periodic : {false, true}) {
    const Box box = uneven_box(2);
    const auto points = make_points<Scalar>(Layout::random, box, many_points);
    const auto plain = ccvt::tessellate(make_problem(points, many_sites, box, periodic));
    std::vector<Index> number(many_points);
    std::iota(number.begin(), number.end(), 0);
    Random random(3);
    random.shuffle(std::span(number));
    Points<Scalar> renumbered(2, many_points);
    for (Index p = 0; p < many_points; ++p) {
      renumbered.col(number[static_cast<std::size_t>(p)]) = points.col(p);
    }
    const auto problem = make_problem(renumbered, many_sites, box, periodic);
    const auto result = ccvt::tessellate(problem);
    CHECK(result.summary.termination == Termination::stable);
    CHECK(ownership_faults(problem, result.owners) == "");
    CHECK(result.summary.energy == doctest::Approx(plain.summary.energy).epsilon(0.01));
  }
}

TEST_CASE("an axis that adds nothing changes no owner") {
  const auto plane = make_points<double>(Layout::random, Box::unit(2), 2000);
  Points<double> space = Points<double>::Constant(3, 2000, 0.25);
  space.topRows(2) = plane;
  // Not the default start: how many neighbours it looks at depends on the dimension.
  for (const auto& options : {Options::balzer2009(), Options::fast_ccvt()}) {
    const auto flat = ccvt::tessellate(plane, 50, options);
    const auto lifted = ccvt::tessellate(space, 50, options);
    CHECK(flat.owners == lifted.owners);
    CHECK(lifted.summary.energy == flat.summary.energy);
    CHECK((lifted.sites.row(2).array() == 0.25).all());
  }
}

TEST_CASE("a torus far larger than its points is a plane") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 2000);
  Problem<double> torus(points, 50);
  torus.set_domain(Domain::periodic({Eigen::Vector2d(-8, -8), Eigen::Vector2d(8, 8)}));
  const auto a = ccvt::tessellate(points, 50);
  const auto b = ccvt::tessellate(torus);
  CHECK(a.owners == b.owners);
  CHECK(a.summary.energy == doctest::Approx(b.summary.energy).epsilon(1e-12));
}

TEST_SUITE_END();
