// How runs end: at once where nothing gains, on demand, and always with exact capacities.
#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "ccvt/solver.h"
#include "support/generate.h"
#include "support/oracle.h"
#include "support/same.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Initialization;
using ccvt::IterationRecord;
using ccvt::Options;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Result;
using ccvt::Solver;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

// The solver itself has no limit of its own: a run that does not end is a failure, not a hang.
Options bounded(Options options = {}) {
  options.max_iterations = 2000;
  return options;
}

template <class Scalar>
Result<Scalar> result_of(const Solver<Scalar>& solver) {
  return {solver.sites(), solver.owners(), solver.summary()};
}

// Coordinates from a set of two values, with weights that make keys tie up to rounding.
template <class Scalar>
Points<Scalar> two_values(int dimension, Index count) {
  Points<Scalar> points(dimension, count);
  for (Index p = 0; p < count; ++p) {
    for (int d = 0; d < dimension; ++d) {
      points(d, p) = static_cast<Scalar>((p >> (d % 8)) % 2 == 0 ? 0.1 : 0.7);
    }
  }
  return points;
}

template <class Scalar>
void check_ends(const Problem<Scalar>& problem, Options options) {
  const auto result = ccvt::tessellate(problem, bounded(std::move(options)));
  CHECK(result.summary.termination == Termination::stable);
  CHECK(faults(problem, result) == "");
}

}  // namespace

TEST_SUITE_BEGIN("termination");

TEST_CASE_TEMPLATE("ties do not keep a run going", Scalar, float, double) {
  for (const bool periodic : {false, true}) {
    for (const int dimension : {1, 2, 3, 5, 9}) {
      if (periodic && dimension > 5) continue;
      const Box box = uneven_box(dimension);
      for (const Layout layout : {Layout::grid, Layout::two_places, Layout::one_place}) {
        for (const auto start : {Initialization::balanced, Initialization::random}) {
          for (const Index sites : {2, 3, 40}) {
            CAPTURE(periodic);
            CAPTURE(dimension);
            CAPTURE(name_of(layout));
            CAPTURE(sites);
            const auto points = make_points<Scalar>(layout, box, 729);
            Problem<Scalar> problem(points, sites);
            if (periodic) problem.set_domain(Domain::periodic(box));
            check_ends(problem, {.initialization = start});
          }
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("a large grid of which every cell ties", Scalar, float, double) {
  Points<Scalar> points(2, 64 * 64);
  for (Index p = 0; p < points.cols(); ++p) {
    points(0, p) = static_cast<Scalar>((p % 64) * 0.1);
    points(1, p) = static_cast<Scalar>(static_cast<double>(p / 64) * 0.1);
  }
  Box box = Box::unit(2);
  box.upper.eigen() *= 6.4;
  for (const Index sites : {16, 64, 256, 100}) {
    CAPTURE(sites);
    Problem<Scalar> problem(points, sites);
    check_ends(problem, {});
    problem.set_domain(Domain::periodic(box));
    check_ends(problem, {});
    check_ends(problem, Options::fast_ccvt());
  }
}

TEST_CASE_TEMPLATE("two values a coordinate", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 8, 17}) {
    CAPTURE(dimension);
    const auto points = two_values<Scalar>(dimension, 512);
    for (const Index sites : {2, 7, 64}) {
      CAPTURE(sites);
      const Problem<Scalar> problem(points, sites);
      check_ends(problem, {});
      check_ends(problem, {.initialization = Initialization::random, .multilevel = false});
    }
  }
}

TEST_CASE("where all points are one, nothing moves") {
  const auto points = make_points<double>(Layout::one_place, uneven_box(3), 1000);
  for (const bool periodic : {false, true}) {
    Problem<double> problem(points, 30);
    if (periodic) problem.set_domain(Domain::periodic(uneven_box(3)));
    const auto result = ccvt::tessellate(problem, {.multilevel = false});
    CHECK(result.summary.termination == Termination::stable);
    CHECK(result.summary.swaps == 0);
    CHECK(result.summary.iterations == 1);
  }
}

TEST_CASE("the callback sees each iteration and cancels at any") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 5000);
  const Problem<float> problem(points, 60);
  const auto whole = ccvt::tessellate(problem);
  REQUIRE(whole.summary.levels > 1);
  const int last = whole.summary.iterations;
  REQUIRE(last > 4);
  for (int stop = 1; stop <= last; ++stop) {
    CAPTURE(stop);
    std::vector<IterationRecord> seen;
    Options options;
    options.on_iteration = [&](const IterationRecord& record) {
      seen.push_back(record);
      return record.iteration < stop;
    };
    const auto result = ccvt::tessellate(problem, options);
    CHECK(result.summary.termination == Termination::cancelled);
    CHECK(result.summary.iterations == stop);
    CHECK(faults(problem, result) == "");
    REQUIRE(seen.size() == result.summary.iterations_log.size());
    for (std::size_t k = 0; k < seen.size(); ++k) {
      CHECK(seen[k].iteration == static_cast<int>(k) + 1);
      CHECK(seen[k].energy == whole.summary.iterations_log[k].energy);
      CHECK(seen[k].swaps == whole.summary.iterations_log[k].swaps);
    }
  }
}

TEST_CASE("Options::cancelled ends a run between batches") {
  for (const auto& preset : {Options{}, Options::balzer2009(), Options::fast_ccvt()}) {
    for (const int dimension : {2, 9}) {
      const auto points = make_points<float>(Layout::random, Box::unit(dimension), 2000);
      const Problem<float> problem(points, 40);
      int asked = 0;
      Options options = preset;
      options.cancelled = [&] { return ++asked > 1'000'000'000; };
      const auto whole = ccvt::tessellate(problem, options);
      CHECK(whole.summary.termination == Termination::stable);
      const int total = asked;
      CHECK(total >= whole.summary.iterations - 1);
      for (const int stop : {1, 2, 3, 5, total / 3, total / 2, total - 1, total}) {
        CAPTURE(stop);
        asked = 0;
        options.cancelled = [&] { return ++asked >= stop; };
        const auto result = ccvt::tessellate(problem, options);
        // Beside between batches it is asked by the clock, on a busy machine more often.
        if (asked < stop && stop > total / 2) continue;
        CHECK(asked == stop);  // never asked again
        CHECK(result.summary.termination == Termination::cancelled);
        if (stop == 1) {  // in the start, where sites stay as they are
          CHECK(ccvt::capacity_error(result.owners, 40) == 0);
        } else {
          CHECK(faults(problem, result) == "");
        }
      }
    }
  }
}

TEST_CASE("the iteration limit holds, and leaves every point with an owner") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 5000);
  for (const auto start :
       {Initialization::balanced, Initialization::coherent, Initialization::random}) {
    for (const bool periodic : {false, true}) {
      Problem<double> problem(points, 60);
      if (periodic) problem.set_domain(Domain::periodic(Box::unit(2)));
      for (const int limit : {0, 1, 5}) {
        CAPTURE(limit);
        const auto result =
            ccvt::tessellate(problem, {.max_iterations = limit, .initialization = start});
        CHECK(result.summary.termination == Termination::iteration_limit);
        CHECK(result.summary.iterations == limit);
        CHECK(result.summary.iterations_log.size() == static_cast<std::size_t>(limit));
        CHECK(faults(problem, result) == "");
        CHECK(result.summary.initial_energy == result.summary.energy);  // still on a coarse level
      }
    }
  }
}

TEST_CASE("the energy tolerance ends a run as soon as an iteration gains less") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 8000);
  const Problem<double> problem(points, 100);
  const double tolerance = 1e-3;
  Options options{
      .energy_tolerance = tolerance, .initialization = Initialization::random, .multilevel = false};
  const auto result = ccvt::tessellate(problem, options);
  CHECK(result.summary.termination == Termination::energy_tolerance);
  CHECK(faults(problem, result) == "");
  double before = result.summary.initial_energy;
  const auto& log = result.summary.iterations_log;
  REQUIRE(log.size() > 2);
  for (std::size_t k = 0; k < log.size(); ++k) {
    CHECK((before - log[k].energy < tolerance * before) == (k + 1 == log.size()));
    before = log[k].energy;
  }
  options.energy_tolerance = 0;
  CHECK(ccvt::tessellate(problem, options).summary.energy < result.summary.energy);
}

TEST_CASE("Options::cancelled is heard wherever it is asked, also when levels change") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 700);
  const Problem<float> problem(points, 10);
  for (const int stop : {1, 2, 3, 5, 8, 13, 21, 34, 55, 89}) {
    CAPTURE(stop);
    int asked = 0;
    Options options{.threads = 1};
    options.cancelled = [&] {
      // So slowly that each check is due again.
      std::this_thread::sleep_for(std::chrono::milliseconds(21));
      return ++asked >= stop;
    };
    const auto result = ccvt::tessellate(problem, options);
    CHECK(ccvt::capacity_error(result.owners, 10) == 0);
    CHECK(result.summary.termination ==
          (asked >= stop ? Termination::cancelled : Termination::stable));
  }
}

TEST_CASE("the time limit ends a run with capacities exact, on whatever level it is") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 60 * 4096);
  const Problem<float> problem(points, 60);
  const auto unlimited = ccvt::tessellate(problem, {.time_limit = 1e6});
  CHECK(unlimited.summary.termination == Termination::stable);
  const auto first = ccvt::tessellate(problem, {.time_limit = 1e-9});
  CHECK(first.summary.termination == Termination::time_limit);
  CHECK(first.summary.iterations == 0);
  CHECK(ccvt::capacity_error(first.owners, 60) == 0);
  // Time passes on the level where the callback sleeps; before that there is enough of it.
  const double limit = 0.2 + 3 * unlimited.summary.seconds_total;
  for (int level = 0; level < unlimited.summary.levels; ++level) {
    CAPTURE(level);
    Options options{.time_limit = limit};
    options.on_iteration = [&](const ccvt::IterationRecord& record) {
      if (record.level == level) std::this_thread::sleep_for(std::chrono::duration<double>(limit));
      return true;
    };
    const auto result = ccvt::tessellate(problem, options);
    CHECK(result.summary.termination == Termination::time_limit);
    CHECK(ccvt::capacity_error(result.owners, 60) == 0);
    // A busy machine may have had no time to let points join as always, and says so.
    const auto& warnings = result.summary.warnings;
    const bool dealt =
        !warnings.empty() && warnings.front().starts_with("the run ended before all");
    if (!dealt) CHECK(faults(problem, result) == "");
  }
}

TEST_CASE("progress goes from 0 to 1 and does not fall") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 60 * 4096);
  const auto log = ccvt::tessellate(points, 60).summary.iterations_log;
  double before = 0;
  for (const ccvt::IterationRecord& record : log) {
    CHECK(record.progress >= before);
    before = record.progress;
  }
  CHECK(log.front().progress < 0.01);
  CHECK(log.back().progress == doctest::Approx(1));
}

TEST_CASE("step by step is the same as at once") {
  const auto points = make_points<float>(Layout::clusters, uneven_box(3), 4000);
  Problem<float> problem(points, 50);
  problem.set_domain(Domain::periodic(uneven_box(3)));
  const auto whole = ccvt::tessellate(problem, {.cached_passes = 3});
  Solver<float> solver(problem, {.cached_passes = 3});
  int steps = 1;
  while (solver.step()) {
    ++steps;
    // At every step the points that have joined are owned, and no site owns too many.
    std::vector<Index> size(50, 0);
    Index joined = 0;
    for (const Index owner : solver.owners()) {
      if (owner < 0) continue;
      ++joined;
      ++size[static_cast<std::size_t>(owner)];
    }
    REQUIRE(*std::max_element(size.begin(), size.end()) <= 80);
    const auto& record = solver.summary().iterations_log.back();
    // A step that ends a level has let the next points join.
    REQUIRE(joined >= record.points);
  }
  CHECK(steps == whole.summary.iterations);
  CHECK(differences(result_of(solver), whole) == "");
  CHECK_FALSE(solver.step());
  solver.cancel();
  CHECK(differences(result_of(solver), whole) == "");
}

TEST_CASE("cancel() ends a run at any step") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 4000);
  const Problem<float> problem(points, 50);
  for (const int steps : {0, 1, 4, 9}) {
    Solver<float> solver(problem);
    for (int k = 0; k < steps; ++k) REQUIRE(solver.step());
    solver.cancel();
    CHECK(solver.summary().termination == Termination::cancelled);
    CHECK(solver.summary().iterations == steps);
    CHECK_FALSE(solver.step());
    CHECK(faults(problem, result_of(solver)) == "");
  }
}

TEST_CASE_TEMPLATE("a stable tessellation fed back stays as it is", Scalar, float, double) {
  for (const Layout layout : all_layouts) {
    for (const bool periodic : {false, true}) {
      CAPTURE(name_of(layout));
      CAPTURE(periodic);
      const Box box = uneven_box(2);
      const auto capacities = unequal_capacities(20);
      const auto points = make_points<Scalar>(layout, box, sum_of(capacities));
      Problem<Scalar> problem(points, 20);
      problem.set_capacities(capacities);
      if (periodic) problem.set_domain(Domain::periodic(box));
      const auto first = ccvt::tessellate(problem);
      problem.set_initial_owners(first.owners);
      // A cell that winds round the torus has several centroids: say which.
      problem.set_initial_sites(first.sites);
      const auto second = ccvt::tessellate(problem);
      CHECK(second.summary.initialization_used == "owners");
      CHECK(second.summary.termination == Termination::stable);
      CHECK(second.owners == first.owners);
      CHECK(second.summary.swaps == 0);
      CHECK(second.summary.iterations == 1);
      CHECK(faults(problem, second) == "");
    }
  }
}

TEST_CASE_TEMPLATE("a warm start from any owners ends stable", Scalar, float, double) {
  for (const int dimension : {1, 2, 9}) {
    const auto points = make_points<Scalar>(Layout::random, uneven_box(dimension), 600);
    Problem<Scalar> problem(points, 30);
    std::vector<Index> owners(600);
    for (std::size_t p = 0; p < owners.size(); ++p) owners[p] = static_cast<Index>(p % 30);
    problem.set_initial_owners(owners);
    check_ends(problem, {});
    const auto limited = ccvt::tessellate(problem, {.max_iterations = 0});
    CHECK(limited.owners == owners);
    CHECK(faults(problem, limited) == "");
  }
}

TEST_CASE("a solver can be moved in mid-run") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 4000);
  const Problem<float> problem(points, 50);
  Solver<float> solver(problem);
  solver.step();
  Solver<float> moved(std::move(solver));
  moved.step();
  solver = std::move(moved);
  solver.run();
  CHECK(differences(result_of(solver), ccvt::tessellate(problem)) == "");
}

TEST_CASE("a callback that throws leaves a solver that goes on to a stable end") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 3000);
  const Problem<double> problem(points, 50);
  int calls = 0;
  ccvt::Solver<double> solver(problem, {.tile_sites = 1, .cancelled = [&]() -> bool {
                                          if (++calls == 5) throw std::runtime_error("enough");
                                          return false;
                                        }});
  CHECK_THROWS_WITH_AS(solver.run(), "enough", std::runtime_error);
  solver.run();
  CHECK(solver.summary().termination == Termination::stable);
  CHECK(faults(problem, result_of(solver)) == "");
}

TEST_SUITE_END();
