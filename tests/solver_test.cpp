// What tessellate() returns, against the definition: see support/oracle.h.
#include "ccvt/solver.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/linear_map.h"
#include "ccvt/lloyd.h"
#include "ccvt/metrics.h"
#include "ccvt/problem.h"
#include "ccvt/weighted.h"
#include "support/generate.h"
#include "support/oracle.h"
#include "support/same.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Solver;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

template <class Scalar>
void check_stable(const Problem<Scalar>& problem, const Options& options = {}) {
  const auto result = ccvt::tessellate(problem, options);
  CHECK(result.summary.termination == Termination::stable);
  CHECK(faults(problem, result) == "");
}

template <class Scalar>
void check_layouts(int dimension, bool periodic) {
  const Box box = uneven_box(dimension);
  for (const Layout layout : all_layouts) {
    for (const bool equal : {true, false}) {
      CAPTURE(name_of(layout));
      CAPTURE(equal);
      const Index sites = equal ? 23 : 14;
      const auto capacities = unequal_capacities(sites);
      const auto points = make_points<Scalar>(layout, box, equal ? 701 : sum_of(capacities));
      Problem<Scalar> problem(points, sites);
      if (!equal) problem.set_capacities(capacities);
      if (periodic) problem.set_domain(Domain::periodic(box));
      check_stable(problem, {.seed = 3});
    }
  }
}

template <class Scalar, int Dimension>
void check_fixed_is_dynamic() {
  const Box box = uneven_box(Dimension);
  const Points<Scalar> dynamic = make_points<Scalar>(Layout::random, box, 500);
  const Eigen::Matrix<Scalar, Dimension, Eigen::Dynamic> fixed = dynamic;
  const auto a = ccvt::tessellate(dynamic, 20);
  const auto b = ccvt::tessellate(fixed, 20);
  static_assert(decltype(b.sites)::RowsAtCompileTime == Dimension);
  CHECK(differences(a, b) == "");
}

}  // namespace

TEST_SUITE_BEGIN("solver");

TEST_CASE_TEMPLATE("a Euclidean tessellation is what it claims", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 4, 5, 8, 17, 64}) {
    CAPTURE(dimension);
    check_layouts<Scalar>(dimension, false);
  }
}

TEST_CASE_TEMPLATE("a periodic tessellation is what it claims", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 4, 5}) {
    CAPTURE(dimension);
    check_layouts<Scalar>(dimension, true);
  }
}

// Many tiles, levels and batches; lists of pairs, where fewer sites make do with all pairs.
TEST_CASE_TEMPLATE("so is a tessellation of many sites", Scalar, float, double) {
  struct Case {
    int dimension;
    Index sites;
    Index each;
    Layout layout;
    bool periodic;
  };
  for (const auto& c : {Case{2, 400, 66, Layout::random, false},
                        {2, 400, 65, Layout::grid, true},
                        {2, 300, 20, Layout::clusters, false},
                        {3, 300, 20, Layout::random, true},
                        {3, 256, 20, Layout::grid, false},
                        {9, 130, 17, Layout::clusters, false}}) {
    CAPTURE(c.dimension);
    CAPTURE(c.periodic);
    CAPTURE(name_of(c.layout));
    const Box box = uneven_box(c.dimension);
    const auto points = make_points<Scalar>(c.layout, box, c.sites * c.each + 5);
    Problem<Scalar> problem(points, c.sites);
    if (c.periodic) problem.set_domain(Domain::periodic(box));
    check_stable(problem);
  }
}

TEST_CASE_TEMPLATE("the smallest problems", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 9}) {
    for (const bool periodic : {false, true}) {
      if (periodic && dimension > 5) continue;
      for (const auto layout : all_layouts) {
        for (const auto& size : {std::pair<Index, Index>{1, 1},
                                 {2, 1},
                                 {2, 2},
                                 {3, 2},
                                 {8, 2},
                                 {50, 1},
                                 {50, 2},
                                 {50, 49},
                                 {50, 50}}) {
          const Index points = size.first;
          const Index sites = size.second;
          CAPTURE(dimension);
          CAPTURE(periodic);
          CAPTURE(name_of(layout));
          CAPTURE(points);
          CAPTURE(sites);
          const Box box = uneven_box(dimension);
          const auto coordinates = make_points<Scalar>(layout, box, points);
          Problem<Scalar> problem(coordinates, sites);
          if (periodic) problem.set_domain(Domain::periodic(box));
          check_stable(problem);
        }
      }
    }
  }
}

TEST_CASE("one point a site costs nothing") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 100);
  const auto result = ccvt::tessellate(points, 100);
  CHECK(result.summary.energy == 0);
  for (Index p = 0; p < 100; ++p) {
    CHECK(result.sites.col(result.owners[static_cast<std::size_t>(p)]) == points.col(p));
  }
}

TEST_CASE("in one dimension the cells of equal sites are intervals") {
  const auto points = make_points<double>(Layout::random, Box::unit(1), 400);
  const auto result = ccvt::tessellate(points, 20);
  std::vector<std::pair<double, Index>> sorted;
  for (Index p = 0; p < 400; ++p) {
    sorted.emplace_back(points(0, p), result.owners[static_cast<std::size_t>(p)]);
  }
  std::sort(sorted.begin(), sorted.end());
  int borders = 0;
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    borders += sorted[k].second != sorted[k - 1].second ? 1 : 0;
  }
  CHECK(borders == 19);
}

TEST_CASE("on a torus a cell may lie across the border") {
  // Two clouds of a circle of length 8, one of them around the place where it is glued.
  Points<double> points(1, 6);
  points << 7.5, 0.0, 0.5, 3.5, 4.0, 4.5;
  Box box = Box::unit(1);
  box.upper[0] = 8;
  Problem<double> problem(points, 2);
  problem.set_domain(Domain::periodic(box));
  const auto result = ccvt::tessellate(problem);
  CHECK(result.summary.energy == 1);
  CHECK(result.owners[0] == result.owners[1]);
  CHECK(result.owners[0] == result.owners[2]);
  CHECK(result.sites(0, result.owners[0]) == 0);
  CHECK(result.sites(0, result.owners[3]) == 4);
}

TEST_CASE_TEMPLATE("fixed and dynamic dimensions agree bit for bit", Scalar, float, double) {
  check_fixed_is_dynamic<Scalar, 1>();
  check_fixed_is_dynamic<Scalar, 2>();
  check_fixed_is_dynamic<Scalar, 3>();
  check_fixed_is_dynamic<Scalar, 4>();
  check_fixed_is_dynamic<Scalar, 17>();
}

TEST_CASE_TEMPLATE("points are read in place, whatever their stride", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 9}) {
    const auto points = make_points<Scalar>(Layout::random, uneven_box(dimension), 300);
    // What lies between the points must not be read.
    Points<Scalar> large =
        Points<Scalar>::Constant(dimension + 5, 304, std::numeric_limits<Scalar>::quiet_NaN());
    large.block(2, 3, dimension, 300) = points;
    const auto a = ccvt::tessellate(points, 20);
    const auto b = ccvt::tessellate(large.block(2, 3, dimension, 300), 20);
    CHECK(differences(a, b) == "");
  }
}

TEST_CASE("a row vector is a set of points on a line") {
  const Eigen::RowVectorXd row = make_points<double>(Layout::random, Box::unit(1), 300);
  const Points<double> matrix = row;
  CHECK(differences(ccvt::tessellate(row, 20), ccvt::tessellate(matrix, 20)) == "");
}

TEST_CASE_TEMPLATE("initial sites may be anywhere", Scalar, float, double) {
  const Box box = uneven_box(2);
  const auto points = make_points<Scalar>(Layout::random, box, 600);
  for (const bool periodic : {false, true}) {
    for (const double distance : {0.0, 3.0, 1e6, 1e15}) {
      for (const Index count : {1, 2, 20}) {
        CAPTURE(periodic);
        CAPTURE(distance);
        CAPTURE(count);
        Points<Scalar> start = make_points<Scalar>(Layout::random, box, count, 5);
        start.array() += static_cast<Scalar>(distance);
        Problem<Scalar> problem(points, count);
        if (periodic) problem.set_domain(Domain::periodic(box));
        problem.set_initial_sites(start);
        check_stable(problem);
        check_stable(problem, {.multilevel = false});
      }
    }
  }
}

TEST_CASE("sites keep the numbers of their initial sites and capacities") {
  // Far apart clouds of 1, 2, ... 9 points: each site must end in its own.
  Points<double> points(2, 45);
  Points<double> start(2, 9);
  std::vector<Index> capacities;
  Index p = 0;
  for (Index s = 0; s < 9; ++s) {
    capacities.push_back(s + 1);
    start.col(s) << 100 * ((s * 5) % 9), 7;
    for (Index k = 0; k <= s; ++k) points.col(p++) << start(0, s) + k, 7;
  }
  Problem<double> problem(points, 9);
  problem.set_capacities(capacities).set_initial_sites(start);
  const auto result = ccvt::tessellate(problem);
  for (Index s = 0; s < 9; ++s) {
    CHECK(result.sites(0, s) == start(0, s) + s / 2.0);
    CHECK(result.sites(1, s) == 7);
  }
  CHECK(result.summary.swaps == 0);
}

TEST_CASE_TEMPLATE("far from the origin", Scalar, float, double) {
  // There points have few distinct coordinates, and sites are rounded coarsely.
  const double offset = sizeof(Scalar) == 4 ? 0x1p16 : 0x1p44;
  for (const bool periodic : {false, true}) {
    Box box = uneven_box(3);
    box.lower.eigen().array() += offset;
    box.upper.eigen().array() += offset;
    for (const Layout layout : all_layouts) {
      CAPTURE(periodic);
      CAPTURE(name_of(layout));
      const auto points = make_points<Scalar>(layout, box, 600);
      Problem<Scalar> problem(points, 30);
      if (periodic) problem.set_domain(Domain::periodic(box));
      check_stable(problem);
    }
  }
}

TEST_CASE("a torus far from the origin, where float sites are rounded more than points are apart") {
  Box box = Box::unit(2);
  box.lower.eigen().array() += 8192;
  box.upper.eigen().array() += 8192;
  const auto points = make_points<float>(Layout::random, box, 1024 * 64);
  Problem<float> problem(points, 1024);
  problem.set_domain(Domain::periodic(box));
  check_stable(problem);
}

TEST_CASE_TEMPLATE("huge and tiny coordinates", Scalar, float, double) {
  for (const double scale :
       sizeof(Scalar) == 4 ? std::vector{1e16, 1e-15} : std::vector{1e139, 1e-139}) {
    for (const bool periodic : {false, true}) {
      CAPTURE(scale);
      CAPTURE(periodic);
      Box box = uneven_box(2);
      box.lower.eigen() *= scale;
      box.upper.eigen() *= scale;
      const auto points = make_points<Scalar>(Layout::random, box, 600);
      Problem<Scalar> problem(points, 30);
      if (periodic) problem.set_domain(Domain::periodic(box));
      check_stable(problem);
    }
  }
}

TEST_CASE_TEMPLATE("points on both faces of a periodic box", Scalar, float, double) {
  // Opposite faces are one: a site on the upper one stands on the lower one, at no distance.
  Points<Scalar> points(2, 25);
  for (Eigen::Index k = 0; k < 25; ++k) {
    points.col(k) << static_cast<Scalar>(k % 5) / 4, static_cast<Scalar>(k / 5) / 4;
  }
  Problem<Scalar> each(points, 25);
  each.set_domain(Domain::periodic(Box::unit(2)));
  CHECK(ccvt::tessellate(each).summary.energy == 0);

  const Points<Scalar> corner = Points<Scalar>::Ones(2, 12);
  Problem<Scalar> one_place(corner, 4);
  one_place.set_domain(Domain::periodic(Box::unit(2)));
  const auto result = ccvt::tessellate(one_place);
  CHECK(result.summary.energy == 0);
  CHECK(result.sites.isZero());
}

static_assert(!std::is_constructible_v<Problem<float>, ccvt::Points<float>, Index>);
static_assert(!std::is_constructible_v<Problem<float>, const ccvt::Points<float>, Index>);
static_assert(!std::is_constructible_v<Problem<float>, ccvt::Columns<float>, Index>);
static_assert(!std::is_constructible_v<Problem<float>, const ccvt::Columns<float>, Index>);
static_assert(std::is_constructible_v<Problem<float>, const ccvt::Points<float>&, Index>);

TEST_CASE("columns, as readers give them, are points as Eigen's matrices are") {
  const auto matrix = make_points<double>(Layout::random, Box::unit(2), 500);
  const ccvt::Columns<double> points = matrix;
  const auto expected = ccvt::tessellate(matrix, 20);
  const auto result = ccvt::tessellate(points, 20);
  CHECK(result.sites == expected.sites);
  CHECK(result.owners == expected.owners);
  const ccvt::Problem problem(points, 20);
  CHECK(ccvt::tessellate(problem).sites == expected.sites);
  CHECK(ccvt::energy(points, ccvt::Columns<double>(result.sites), result.owners) ==
        ccvt::energy(matrix, result.sites, result.owners));
  CHECK(ccvt::energy(points, result.sites, result.owners) ==
        ccvt::energy(matrix, result.sites, result.owners));
  CHECK(ccvt::lloyd(points, 20).sites == ccvt::lloyd(matrix, 20).sites);
  const ccvt::Training trained = ccvt::train_codebook(points, 5);
  const ccvt::Codebook& codebook = trained.codebook;
  CHECK(codebook.codewords() == ccvt::train_codebook(matrix, 5).codebook.codewords());
  CHECK(ccvt::train_codebook_from(points, codebook.codewords()).codebook.codewords() ==
        ccvt::train_codebook_from(matrix, codebook.codewords()).codebook.codewords());
  CHECK(codebook.encode(points) == codebook.encode(matrix));
  CHECK(codebook.distortion(points, trained.codes) == codebook.distortion(matrix, trained.codes));
  const std::vector<double> masses(500, 1.0);
  CHECK(ccvt::tessellate_masses(points, masses, 20).sites ==
        ccvt::tessellate_masses(matrix, masses, 20).sites);
  const auto map = ccvt::LinearMap::units({2, 3});
  CHECK(map(points) == map(matrix));
  CHECK(map.inverse(points) == map.inverse(matrix));
  CHECK(ccvt::LinearMap::whitening(points).matrix() == ccvt::LinearMap::whitening(matrix).matrix());
}

TEST_CASE("what on_loop throws is passed on when the pass has been recorded") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 3000);
  Options options;
  bool fails = false;
  options.on_loop = [&](const ccvt::LoopRecord&) {
    if (std::exchange(fails, false)) throw std::runtime_error("from on_loop");
  };
  Solver<float> solver(Problem<float>(points, 50), options);
  solver.step();
  fails = true;
  CHECK_THROWS_WITH_AS(solver.step(), "from on_loop", std::runtime_error);
  CHECK(solver.summary().iterations == 2);
  solver.run();
  const auto whole = ccvt::tessellate(points, 50);
  CHECK(solver.owners() == whole.owners);
}

TEST_SUITE_END();
