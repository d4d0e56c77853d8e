// Levels that are descended more than once, because pairs creep.
#include <doctest/doctest.h>

#include <cstddef>

#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "run.h"
#include "support/files.h"
#include "support/generate.h"
#include "support/impatient.h"
#include "support/oracle.h"
#include "support/problems.h"
#include "support/same.h"

using ccvt::Box;
using ccvt::Index;
using ccvt::Options;
using ccvt::Problem;
using ccvt::Termination;
using namespace ccvt::test;

TEST_SUITE_BEGIN("descent");

// Pairs are not at their end here when they have changed all sites as often as there is patience
// for.
TEST_CASE("where pairs creep all the same, sites descend again") {
  constexpr Index kSites = 15;
  const auto points =
      ccvt::sample_uniform<float, 2>(Box::unit(2), kSites * 65536, 449, ccvt::Distribution::white);
  const Problem<float> problem(points, kSites);
  const auto summary = ccvt::tessellate(problem, {.seed = 449}).summary;
  CHECK(summary.termination == Termination::stable);
  CHECK(descents_of(summary) == 2);
  CHECK(summary.iterations < 1000);
}

TEST_CASE_TEMPLATE("sites that descend again and again", Scalar, float, double) {
  const auto check = [](Problem<Scalar>& problem, const auto& points, Layout layout) {
    if (layout == Layout::random) problem.set_fixed_sites(points.leftCols(5));
    Options options{.threads = 1, .seed = 2, .level_points = 4, .descent_points = 10};
    const auto result = tessellate_impatiently(problem, options, 0.1);
    CHECK(result.summary.termination == Termination::stable);
    CHECK(faults(problem, result) == "");
    CHECK(descents_of(result.summary) <= ccvt::kMostDescents);
    const auto& log = result.summary.iterations_log;
    for (std::size_t k = 1; k < log.size(); ++k) {
      if (log[k].level != log[k - 1].level) continue;
      REQUIRE(log[k].energy <= log[k - 1].energy * (1 + 1e-14));
      REQUIRE(log[k].progress >= log[k - 1].progress);
    }
    options.threads = 3;
    CHECK(differences(result, tessellate_impatiently(problem, options, 0.1)) == "");
  };
  for_problems<Scalar>({1, 2, 3}, 40 * 60 + 7, 40, check);
}

TEST_CASE("descents one after the other, saved after each iteration") {
  const TemporaryDirectory directory;
  const auto points = make_points<double>(Layout::random, Box::unit(2), 12'000);
  const Problem<double> problem(points, 40);
  const Options options{.threads = 2, .seed = 3, .descent_points = 60};
  const auto whole = tessellate_impatiently(problem, options, 0.2);
  CHECK(descents_of(whole.summary) > 2);
  int steps = 0;
  for (bool more = true; more; ++steps) {
    ccvt::Run<double> run(problem, options);
    run.patience = 0.2;
    if (steps > 0) run.load(directory / "run");
    more = run.step();
    if (more) run.save(directory / "run");
    if (more) continue;
    CHECK(run.owners() == whole.owners);
    CHECK(run.record.summary().energy == whole.summary.energy);
  }
  CHECK(steps == whole.summary.iterations);
}

TEST_CASE("the more points a site, up to a limit, the smaller are gains that end a descent") {
  const auto least_gain = [](Index points, int before) {
    const auto cloud = make_points<float>(Layout::random, Box::unit(2), points);
    return ccvt::Run<float>(Problem<float>(cloud, 2), {.threads = 1}).least_gain(before);
  };
  CHECK(least_gain(2 * 600, 0) == 3e-4);
  CHECK(least_gain(2 * 6000, 0) == doctest::Approx(2e-4));
  CHECK(least_gain(2 * 20000, 0) == 1e-4);
  CHECK(least_gain(2 * 20000, 2) == doctest::Approx(1e-4 / 16));
}

TEST_SUITE_END();
