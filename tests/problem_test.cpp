// What the library refuses, and how it says so.
#include "ccvt/problem.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/lloyd.h"
#include "ccvt/metrics.h"
#include "ccvt/options.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/tessellation.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::InvalidInput;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;

namespace {

constexpr double not_a_number = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

struct Refusal {
  std::function<void()> mistake;
  /// The argument, its value and index: each must be in the message.
  std::vector<std::string> named;
};

void check_refused(const std::vector<Refusal>& refusals) {
  for (std::size_t row = 0; row < refusals.size(); ++row) {
    CAPTURE(row);
    try {
      refusals[row].mistake();
      FAIL_CHECK("accepted");
    } catch (const InvalidInput& error) {
      const std::string message = error.what();
      CAPTURE(message);
      CHECK(message.find('\n') == std::string::npos);
      for (const std::string& word : refusals[row].named) {
        CAPTURE(word);
        CHECK(message.find(word) != std::string::npos);
      }
    }
  }
}

// (0, 0), (1, 0), (2, 0), …
template <class Scalar = double>
Points<Scalar> row_of_points(Index count) {
  Points<Scalar> points = Points<Scalar>::Zero(2, count);
  for (Index p = 0; p < count; ++p) points(0, p) = static_cast<Scalar>(p);
  return points;
}

template <class Scalar>
Points<Scalar> with_value(double value) {
  Points<Scalar> points = row_of_points<Scalar>(6);
  points(1, 4) = static_cast<Scalar>(value);
  return points;
}

Box box(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) { return {lower, upper}; }

}  // namespace

TEST_SUITE_BEGIN("problem");

TEST_CASE("numbers of points and sites") {
  const auto points = row_of_points(6);
  const Points<double> none(2, 0);
  const Points<double> flat(0, 6);
  check_refused({
      {[&] { Problem<double>(points, 0); }, {"sites", "0", "6"}},
      {[&] { Problem<double>(points, -3); }, {"sites", "-3"}},
      {[&] { Problem<double>(points, 7); }, {"sites", "7", "6"}},
      {[&] { Problem<double>(none, 1); }, {"points", "none"}},
      {[&] { Problem<double>(flat, 1); }, {"points", "dimension"}},
      {[&] { ccvt::tessellate(points, 7); }, {"sites", "7", "6"}},
      {[&] { ccvt::tessellate(none, 1); }, {"points"}},
  });
  CHECK_NOTHROW(Problem<double>(points, 1));
  CHECK_NOTHROW(Problem<double>(points, 6));
}

TEST_CASE_TEMPLATE("coordinates", Scalar, float, double) {
  const auto large = sizeof(Scalar) == sizeof(float) ? 1e18 : 1e141;
  for (const double value : {not_a_number, infinity, -infinity, large, -large}) {
    CAPTURE(value);
    const auto points = with_value<Scalar>(value);
    check_refused({{[&] { Problem<Scalar>(points, 2); }, {"points[4]", "coordinate 1"}}});
  }
  check_refused({{[] {
                    const auto p = with_value<Scalar>(not_a_number);
                    Problem<Scalar>(p, 2);
                  },
                  {"nan"}},
                 {[] {
                    const auto p = with_value<Scalar>(-infinity);
                    Problem<Scalar>(p, 2);
                  },
                  {"-inf"}}});
  const auto points = with_value<Scalar>(large / 100);
  CHECK_NOTHROW(Problem<Scalar>(points, 2));
}

TEST_CASE("a strided view is checked as far as its points go, and no farther") {
  Points<double> points = Points<double>::Constant(4, 6, not_a_number);
  points.topRows(2) = row_of_points(6);
  CHECK_NOTHROW(Problem<double>(points.topRows(2), 2));
  points(1, 5) = infinity;
  check_refused({{[&] { Problem<double>(points.topRows(2), 2); }, {"points[5]", "inf"}}});
}

TEST_CASE("boxes") {
  using Eigen::Vector2d;
  for (const auto make : {&Domain::periodic, &Domain::euclidean}) {
    check_refused({
        {[&] { make(box(Vector2d(0, 0), Vector2d(1, 0))); }, {"box", "dimension 1", "0"}},
        {[&] { make(box(Vector2d(0, 3), Vector2d(1, 2))); }, {"box", "dimension 1", "3", "2"}},
        {[&] { make(box(Vector2d(not_a_number, 0), Vector2d(1, 1))); },
         {"box", "dimension 0", "nan"}},
        {[&] { make(box(Vector2d(0, 0), Vector2d(1, not_a_number))); },
         {"box", "dimension 1", "nan"}},
        {[&] { make(box(Vector2d(0, -infinity), Vector2d(1, 1))); }, {"dimension 1", "-inf"}},
        {[&] { make(box(Vector2d(0, 0), Vector2d(infinity, 1))); }, {"dimension 0", "inf"}},
        {[&] { make(box(Vector2d(-1e308, 0), Vector2d(1e308, 1))); }, {"dimension 0", "1e+308"}},
        {[&] { make(box(Vector2d(0, 0), Eigen::Vector3d(1, 1, 1))); }, {"box", "2", "3"}},
        {[&] { make(box(Eigen::VectorXd(0), Eigen::VectorXd(0))); }, {"box", "0"}},
    });
  }
}

TEST_CASE("domains that do not hold the points") {
  using Eigen::Vector2d;
  const auto points = row_of_points(6);
  for (const auto make : {&Domain::periodic, &Domain::euclidean}) {
    Problem<double> problem(points, 2);
    check_refused({
        {[&] { problem.set_domain(make(Box::unit(3))); }, {"domain", "3", "2"}},
        {[&] { problem.set_domain(make(Box::unit(1))); }, {"domain", "1", "2"}},
        {[&] { problem.set_domain(make(box(Vector2d(0, 0), Vector2d(9, 1e300)))); },
         {"domain", "coordinate 1", "upper", "1e+300", "at most"}},
        {[&] { problem.set_domain(make(box(Vector2d(-1e151, 0), Vector2d(9, 1)))); },
         {"domain", "coordinate 0", "lower", "-1e+151", "at most"}},
        {[&] { problem.set_domain(make(box(Vector2d(0, 0), Vector2d(4.5, 1)))); },
         {"points[5]", "coordinate 0", "5", "4.5"}},
        {[&] { problem.set_domain(make(box(Vector2d(0.25, 0), Vector2d(9, 1)))); },
         {"points[0]", "coordinate 0", "0.25"}},
        {[&] { problem.set_domain(make(box(Vector2d(0, 0.125), Vector2d(9, 1)))); },
         {"points[0]", "coordinate 1", "0.125"}},
    });
    CHECK_FALSE(problem.domain().has_box());  // refused whole
    // Both faces belong to the box.
    CHECK_NOTHROW(problem.set_domain(make(box(Vector2d(0, 0), Vector2d(5, 1)))));
    CHECK(problem.domain().box().upper[0] == 5);
  }
}

TEST_CASE("capacities") {
  const auto points = row_of_points(6);
  Problem<double> problem(points, 3);
  check_refused({
      {[&] {
         problem.set_capacities({3, 3});
       },
       {"capacities", "2", "3"}},
      {[&] { problem.set_capacities({}); }, {"capacities", "0", "3"}},
      {[&] {
         problem.set_capacities({1, 1, 1});
       },
       {"capacities", "3", "6"}},
      {[&] {
         problem.set_capacities({4, 2, 1});
       },
       {"capacities", "7", "6"}},
      {[&] {
         problem.set_capacities({4, 0, 2});
       },
       {"capacities[1]", "0"}},
      {[&] {
         problem.set_capacities({4, 3, -1});
       },
       {"capacities[2]", "-1"}},
      // Their sum does not fit Index.
      {[&] {
         problem.set_capacities({2147483647, 2147483647, 8});
       },
       {"capacities", "4294967302"}},
      {[] { ccvt::validate_capacities({}, 0); }, {"capacities"}},
      {[] { ccvt::equal_capacities(5, 6); }, {"sites", "6", "5"}},
      {[] { ccvt::equal_capacities(5, 0); }, {"sites", "0"}},
  });
  CHECK(problem.capacities() == std::vector<Index>{2, 2, 2});
  problem.set_capacities({1, 4, 1});
  CHECK(problem.capacities() == std::vector<Index>{1, 4, 1});
}

TEST_CASE("equal capacities differ by at most one, the larger ones first") {
  for (Index points = 1; points < 40; ++points) {
    for (Index sites = 1; sites <= points; ++sites) {
      const auto capacities = ccvt::equal_capacities(points, sites);
      REQUIRE(capacities.size() == static_cast<std::size_t>(sites));
      REQUIRE(capacities.front() - capacities.back() <= 1);
      REQUIRE(std::is_sorted(capacities.rbegin(), capacities.rend()));
      REQUIRE_NOTHROW(ccvt::validate_capacities(capacities, points));
    }
  }
}

TEST_CASE("initial sites") {
  const auto points = row_of_points(6);
  Problem<double> problem(points, 3);
  const auto sites = [](double value) {
    Points<double> result = row_of_points(3);
    result(1, 2) = value;
    return result;
  };
  check_refused({
      {[&] { problem.set_initial_sites(row_of_points(4)); }, {"initial_sites", "2 by 4", "2 by 3"}},
      {[&] { problem.set_initial_sites(Points<double>::Zero(3, 3)); },
       {"initial_sites", "3 by 3", "2 by 3"}},
      {[&] { problem.set_initial_sites(sites(not_a_number)); },
       {"initial_sites[2]", "coordinate 1", "nan"}},
      {[&] { problem.set_initial_sites(sites(1e200)); }, {"initial_sites[2]", "1e+200"}},
  });
  CHECK(problem.initial_sites().size() == 0);
  CHECK_NOTHROW(problem.set_initial_sites(row_of_points(3)));
}

TEST_CASE("initial owners") {
  const auto points = row_of_points(6);
  Problem<double> problem(points, 3);
  check_refused({
      {[&] {
         problem.set_initial_owners({0, 1, 2});
       },
       {"initial_owners", "3", "6"}},
      {[&] {
         problem.set_initial_owners({0, 0, 1, 1, 2, 3});
       },
       {"initial_owners[5]", "3", "0..2"}},
      {[&] {
         problem.set_initial_owners({0, -1, 1, 1, 2, 2});
       },
       {"initial_owners[1]", "-1"}},
      {[&] {
         problem.set_initial_owners({0, 0, 1, 0, 2, 2});
       },
       {"initial_owners[3]", "0", "capacity 2"}},
  });
  CHECK(problem.initial_owners().empty());
  // Whichever comes second: owners and capacities must agree.
  const std::vector<Index> owners{0, 1, 2, 0, 1, 2};
  problem.set_initial_owners(owners);
  check_refused({{[&] {
                    problem.set_capacities({2, 3, 1});
                  },
                  {"capacities[1]", "3", "initial_owners", "2"}}});
  CHECK(problem.capacities() == std::vector<Index>{2, 2, 2});
  CHECK(problem.initial_owners() == owners);
  CHECK_NOTHROW(problem.set_capacities({2, 2, 2}));
  CHECK(problem.initial_owners() == owners);
  Problem<double> uneven(points, 3);
  check_refused({{[&] {
                    uneven.set_initial_owners({0, 1, 1, 1, 1, 2});
                  },
                  {"initial_owners[3]", "1", "capacity 2", "set first"}}});
  uneven.set_capacities({1, 4, 1});
  CHECK_NOTHROW(uneven.set_initial_owners({0, 1, 1, 1, 1, 2}));
}

TEST_CASE("initial sites and owners, in either order: the same bits") {
  const auto points = ccvt::sample_uniform<double>(ccvt::Box::unit(2), 2000, 3);
  Problem<double> first(points, 20);
  first.set_domain(Domain::periodic(ccvt::Box::unit(2)));
  const auto start = ccvt::tessellate(first, {.max_iterations = 1});
  Problem<double> second = first;
  first.set_initial_owners(start.owners).set_initial_sites(start.sites);
  second.set_initial_sites(start.sites).set_initial_owners(start.owners);
  const auto a = ccvt::tessellate(first);
  const auto b = ccvt::tessellate(second);
  CHECK(a.summary.initialization_used == "owners");
  CHECK(a.owners == b.owners);
  CHECK(a.sites == b.sites);
}

TEST_CASE("a problem that was moved from") {
  const auto points = row_of_points(6);
  Problem<double> problem(points, 3);
  const Problem<double> taken = std::move(problem);
  CHECK_NOTHROW(ccvt::tessellate(taken));
  check_refused({
      // NOLINTBEGIN(bugprone-use-after-move)
      {[&] { ccvt::tessellate(problem); }, {"problem", "no sites", "moved"}},
      {[&] { ccvt::lloyd(problem); }, {"problem", "no sites", "moved"}},
      // NOLINTEND(bugprone-use-after-move)
  });
}

TEST_CASE("options") {
  const auto points = row_of_points(6);
  const auto solve = [&](const Options& options) { ccvt::tessellate(points, 3, options); };
  check_refused({
      {[&] { solve({.threads = -1}); }, {"threads", "-1"}},
      {[&] { solve({.threads = 5000}); }, {"threads", "5000", "4096"}},
      {[&] { solve({.max_iterations = -2}); }, {"max_iterations", "-2"}},
      {[&] { solve({.energy_tolerance = -0.5}); }, {"energy_tolerance", "-0.5"}},
      {[&] { solve({.energy_tolerance = 1}); }, {"energy_tolerance", "1"}},
      {[&] { solve({.energy_tolerance = not_a_number}); }, {"energy_tolerance", "nan"}},
      {[&] { solve({.time_limit = -1}); }, {"time_limit", "-1"}},
      {[&] { solve({.time_limit = not_a_number}); }, {"time_limit", "nan"}},
      {[&] { solve({.descent_points = -1}); }, {"descent_points", "-1"}},
      {[&] { solve({.level_points = 0}); }, {"level_points", "0"}},
      {[&] { solve({.swap = static_cast<ccvt::SwapMethod>(77)}); }, {"swap", "77"}},
      {[&] { solve({.initialization = static_cast<ccvt::Initialization>(-1)}); },
       {"initialization", "-1"}},
      {[&] { solve({.level_factor = 1}); }, {"level_factor", "1"}},
      {[&] { solve({.cached_passes = -1}); }, {"cached_passes", "-1"}},
      {[&] { solve({.tile_sites = 0}); }, {"tile_sites", "0"}},
  });
  for (const auto& preset :
       {Options{}, Options::balzer2009(), Options::section4(), Options::fast_ccvt()}) {
    CHECK_NOTHROW(preset.validate());
  }
  // The largest values that are allowed must not overflow anywhere.
  CHECK_NOTHROW(solve({.level_points = 2147483647}));
  CHECK_NOTHROW(solve({.level_factor = 2147483647}));
  CHECK_NOTHROW(solve({.time_limit = 1e300}));
  CHECK_NOTHROW(solve({.time_limit = infinity}));
  CHECK_NOTHROW(solve({.descent_points = 2147483647}));
  CHECK_NOTHROW(solve({.level_points = 2147483647, .level_factor = 2147483647}));
  CHECK_NOTHROW(solve({.cached_passes = 2147483647}));
  CHECK_NOTHROW(solve({.tile_sites = 2147483647}));
  CHECK_NOTHROW(solve({.pairs = ccvt::PairSelection::all, .tile_sites = 2147483647}));
}

TEST_CASE("tessellations and capacity errors") {
  const std::vector<Index> owners{0, 2, 1, 2, 0};
  const std::vector<Index> none;
  check_refused({
      {[&] { ccvt::Tessellation(owners, 2); }, {"owners[1]", "2", "0..1"}},
      {[&] { ccvt::Tessellation(owners, 0); }, {"sites", "0"}},
      {[&] { ccvt::capacity_error(owners, 2); }, {"owners[1]", "2", "0..1"}},
      {[&] { ccvt::capacity_error(owners, -1); }, {"sites", "-1"}},
      {[&] { ccvt::capacity_error(none, 3); }, {"owners", "none"}},
  });
  const ccvt::Tessellation cells(owners, 4);
  CHECK(std::vector<Index>(cells.cell(0).begin(), cells.cell(0).end()) == std::vector<Index>{0, 4});
  CHECK(std::vector<Index>(cells.cell(2).begin(), cells.cell(2).end()) == std::vector<Index>{1, 3});
  CHECK(cells.cell(3).empty());
  CHECK(cells.point_count() == 5);
  CHECK(cells.site_count() == 4);
  CHECK(ccvt::capacity_error(std::vector<Index>{0, 1, 0, 1}, 2) == 0);
  // Sizes 3 and 1 of a mean of 2: (1/4 + 1/4) / 2.
  CHECK(ccvt::capacity_error(std::vector<Index>{0, 1, 0, 0}, 2) == 0.25);
}

TEST_CASE("points whose coordinates are not contiguous are refused") {
  Eigen::MatrixXf storage = Eigen::MatrixXf::Random(4, 40);
  using Gaps = Eigen::Map<Eigen::MatrixXf, 0, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>>;
  const Gaps points(storage.data(), 2, 40, Eigen::Stride<Eigen::Dynamic, Eigen::Dynamic>(4, 2));
  CHECK_THROWS_AS(ccvt::Problem<float>(points, 3), ccvt::InvalidInput);
}

TEST_CASE_TEMPLATE("points on the faces of a box are inside, whatever their type", Scalar, float,
                   double) {
  // Of the corners, some are rounded up to float32 and others down.
  const Box box{{.1, -.3, .7}, {.9, 1.1, 1.3}};
  Points<Scalar> points = Points<Scalar>::Constant(3, 9, Scalar(.8));
  for (int d = 0; d < 3; ++d) {
    points(d, 2 * d) = static_cast<Scalar>(box.lower[d]);
    points(d, 2 * d + 1) = static_cast<Scalar>(box.upper[d]);
  }
  std::vector<Index> own(9);
  std::iota(own.begin(), own.end(), 0);
  for (const Domain& domain : {Domain::euclidean(box), Domain::periodic(box)}) {
    Problem<Scalar> problem(points, 3);
    problem.set_domain(domain);
    CHECK(ccvt::tessellate(problem).summary.energy > 0);
    // No narrower than it was, and no wider than its points need.
    const Box& widened = problem.domain().box();
    for (int d = 0; d < 3; ++d) {
      CHECK(widened.lower[d] == std::min<double>(box.lower[d], points(d, 2 * d)));
      CHECK(widened.upper[d] == std::max<double>(box.upper[d], points(d, 2 * d + 1)));
    }
    CHECK(ccvt::energy(points, points, own, domain) == 0);
    CHECK_NOTHROW(ccvt::PointSet(points, domain));
    points(1, 4) = std::nextafter(points(1, 3), Scalar(9));
    CHECK_THROWS_AS(problem.set_domain(domain), InvalidInput);
    points(1, 4) = Scalar(.8);
  }
  // Without points on its faces, it stays as it is.
  const Points<Scalar> far = Points<Scalar>::Constant(1, 3, Scalar(1000));
  Problem<Scalar> problem(far, 2);
  problem.set_domain(Domain::periodic(Box{{999.7}, {1000.1}}));
  CHECK(problem.domain().box().lower[0] == 999.7);
  CHECK(problem.domain().box().upper[0] == 1000.1);
}

TEST_SUITE_END();
