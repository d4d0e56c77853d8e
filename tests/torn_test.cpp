// Clouds: cells that exchanges between pairs of sites would leave torn.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "random.h"
#include "support/files.h"
#include "support/oracle.h"
#include "support/same.h"
#include "support/thread_ranks.h"

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

constexpr Index kSites = 64;
constexpr Index kPoints = kSites * 256;
/// From where exchanges alone would end at 1.8 times the energy, in clouds(5).
constexpr std::uint64_t kTornWithout = 1;

/// Sixteen clouds that overlap, each a quarter narrower than the one before, in or near [0, 1]^2.
template <class Scalar>
Points<Scalar> clouds(std::uint64_t seed, Index count = kPoints) {
  constexpr Index kClouds = 16;
  Random random(seed);
  Points<Scalar> points(2, count);
  for (Index cloud = 0; cloud < kClouds; ++cloud) {
    const double x = random.uniform();
    const double y = random.uniform();
    for (Index p = cloud; p < count; p += kClouds) {
      const double radius =
          0.1 * std::pow(0.75, cloud) * std::sqrt(-2 * std::log(1 - random.uniform()));
      const double angle = 2 * std::numbers::pi * random.uniform();
      points(0, p) = static_cast<Scalar>(x + radius * std::cos(angle));
      points(1, p) = static_cast<Scalar>(y + radius * std::sin(angle));
    }
  }
  return points;
}

/// Of a torus: clouds reach across its faces.
template <class Scalar>
Points<Scalar> into_unit_box(const Points<Scalar>& points) {
  return points.array() - points.array().floor();
}

/// The largest of the energies from so many beginnings, over the least one. `exhaustive`: whether
/// the first of the results is compared with what it must be, which takes long for many sites.
double spread_of_energies(const Problem<float>& problem, std::uint64_t begins, bool exhaustive) {
  double least = std::numeric_limits<double>::infinity();
  double most = 0;
  for (std::uint64_t begin = 1; begin <= begins; ++begin) {
    const auto result = ccvt::tessellate(problem, Options{.threads = 2, .seed = begin});
    CHECK(result.summary.termination == Termination::stable);
    least = std::min(least, result.summary.energy);
    most = std::max(most, result.summary.energy);
    if (begin == 1 && exhaustive) CHECK(faults(problem, result) == "");
  }
  return most / least;
}

/// The result of one thread, which three threads and three ranks must have too. `set_up(problem)`:
/// what is to be known besides points and sites.
template <class Scalar, class SetUp>
ccvt::Result<Scalar> result_of_any_workers(const Points<Scalar>& points, Index sites,
                                           std::uint64_t seed, const SetUp& set_up) {
  Problem<Scalar> problem(points, sites);
  set_up(problem);
  auto expected = ccvt::tessellate(problem, Options{.threads = 1, .seed = seed});
  CHECK(faults(problem, expected) == "");
  const auto threaded = ccvt::tessellate(problem, Options{.threads = 3, .seed = seed});
  CHECK(threaded.owners == expected.owners);
  CHECK(threaded.summary.energy == expected.summary.energy);
  std::vector<int> same(3, 0);
  ThreadRanks(3).run([&](ccvt::Ranks& ranks) {
    const auto place = [&](int rank) { return static_cast<Index>(points.cols() * rank / 3); };
    const Index begin = place(ranks.rank());
    const Points<Scalar> own = points.middleCols(begin, place(ranks.rank() + 1) - begin);
    Problem<Scalar> part(ranks, ccvt::view_points(own), sites);
    set_up(part);
    const auto result = ccvt::tessellate(part, Options{.threads = 1, .seed = seed});
    same[static_cast<std::size_t>(ranks.rank())] =
        result.summary.energy == expected.summary.energy && result.sites == expected.sites &&
        std::equal(result.owners.begin(), result.owners.end(), expected.owners.begin() + begin);
  });
  CHECK(same == std::vector<int>(3, 1));
  return expected;
}

}  // namespace

TEST_SUITE_BEGIN("torn");

TEST_CASE("in clouds the energy does not hang on where sites begin") {
  for (const std::uint64_t seed : std::initializer_list<std::uint64_t>{1, 5, 6}) {
    CAPTURE(seed);
    const Points<float> points = clouds<float>(seed);
    CHECK(spread_of_energies(Problem<float>(points, kSites), 6, true) < 1.1);
  }
}

TEST_CASE("nor does it in large sets, of few points a site, or on a torus") {
  struct Set {
    std::uint64_t seed;
    Index sites;
    Index capacity;
    bool periodic;
    double most;  ///< of the least energy; exchanges alone: 1.3, 3.5 and 2.1 times
  };
  for (const Set& set : {Set{5, 1200, 64, false, 1.05}, Set{1, kSites, 16, false, 1.1},
                         Set{5, kSites, 64, true, 1.05}}) {
    CAPTURE(set.sites);
    CAPTURE(set.periodic);
    Points<float> points = clouds<float>(set.seed, set.sites * set.capacity);
    if (set.periodic) points = into_unit_box(points);
    Problem<float> problem(points, set.sites);
    if (set.periodic) problem.set_domain(Domain::periodic(Box{{0, 0}, {1, 1}}));
    CHECK(spread_of_energies(problem, 5, set.sites == kSites) < set.most);
  }
}

TEST_CASE_TEMPLATE("parts of larger sets are mended alike for any number of threads and ranks",
                   Scalar, float, double) {
  constexpr Index kLarge = 400;
  const Points<Scalar> open = clouds<Scalar>(5, kLarge * 64);
  result_of_any_workers(open, kLarge, 1, [](Problem<Scalar>&) {});
  result_of_any_workers(into_unit_box(open), kLarge, 1, [](Problem<Scalar>& problem) {
    problem.set_domain(Domain::periodic(Box{{0, 0}, {1, 1}}));
  });
}

TEST_CASE_TEMPLATE("cells are mended alike for any number of threads and ranks", Scalar, float,
                   double) {
  const Points<Scalar> points = clouds<Scalar>(5);
  const double least = ccvt::tessellate(points, kSites, Options{.seed = 2}).summary.energy;
  for (const bool periodic : {false, true}) {
    for (const Index fixed : {0, 5}) {
      CAPTURE(periodic);
      CAPTURE(fixed);
      const auto result =
          result_of_any_workers(points, kSites, kTornWithout, [&](Problem<Scalar>& problem) {
            if (periodic) problem.set_domain(Domain::periodic(Box{{-1, -1}, {2, 2}}));
            if (fixed > 0) problem.set_fixed_sites(points.leftCols(fixed));
          });
      if (fixed == 0) CHECK(result.summary.energy < 1.1 * least);
      for (Index s = 0; s < fixed; ++s) CHECK(result.sites.col(s) == points.col(s));
    }
  }
}

TEST_CASE("clouds: capacities that differ, and a run that goes on from each of its iterations") {
  const Points<float> points = clouds<float>(5);
  Problem<float> problem(points, kSites);
  std::vector<Index> capacities(kSites, 128);
  for (std::size_t s = 0; s < capacities.size(); s += 2) capacities[s] = 384;
  problem.set_capacities(capacities);
  Options options{.threads = 2, .seed = kTornWithout};
  const auto expected = ccvt::tessellate(problem, options);
  CHECK(faults(problem, expected) == "");
  const TemporaryDirectory directory;
  options.checkpoint = directory / "kept";
  std::optional<ccvt::Result<float>> result;
  for (options.max_iterations = 1; !result || result->summary.termination != Termination::stable;
       ++options.max_iterations) {
    REQUIRE(options.max_iterations < 1000);
    result = ccvt::tessellate(problem, options);
  }
  CHECK(result->owners == expected.owners);
  CHECK(result->summary.energy == expected.summary.energy);
}

TEST_CASE("a run that ends when the finest level has just been mended tells its energy") {
  const Points<float> points = clouds<float>(5, kSites * 64);
  const Problem<float> problem(points, kSites);
  const auto all = ccvt::tessellate(problem, Options{.threads = 2, .seed = 2});
  bool mended = false;
  for (int most = 1; most <= all.summary.iterations; ++most) {
    CAPTURE(most);
    const auto cut =
        ccvt::tessellate(problem, Options{.threads = 1, .seed = 2, .max_iterations = most});
    CHECK(geometry_faults(problem, Points<float>(cut.sites), cut.owners, cut.summary) == "");
    const auto& log = cut.summary.iterations_log;
    mended = mended || log.back().energy > 1.5 * cut.summary.energy;
  }
  CHECK(mended);  // what the last iteration left was torn, and its end mended it
}

TEST_CASE("sites of very different capacities, and fixed ones, are not mended without end") {
  Random random(3);
  Points<float> points(2, 1000 * 64);
  for (Index p = 0; p < points.cols(); ++p) {
    for (int d = 0; d < 2; ++d) points(d, p) = static_cast<float>(random.uniform());
  }
  Problem<float> unequal(points, 1000);
  std::vector<Index> capacities(1000, 32);
  for (std::size_t s = 0; s < capacities.size(); s += 10) capacities[s] = 352;
  unequal.set_capacities(capacities);
  Problem<float> fixed(points, 1000);
  fixed.set_fixed_sites(points.leftCols(500));
  for (const Problem<float>* problem : {&unequal, &fixed}) {
    const auto result = ccvt::tessellate(*problem, Options{.threads = 2, .time_limit = 20});
    CHECK(result.summary.termination == Termination::stable);
    CHECK(ownership_faults(*problem, result.owners) == "");
    CHECK(descent_faults(*problem, result.summary) == "");
  }
}

TEST_CASE("a run that is cancelled anywhere in clouds has a result") {
  const Points<double> points = clouds<double>(5, kSites * 1024);
  const Problem<double> problem(points, kSites);
  int asked = 0;
  int most = 1;
  for (bool ended = false; !ended; most += 1 + most / 4) {
    CAPTURE(most);
    asked = 0;
    const auto result = ccvt::tessellate(
        problem, Options{.threads = 1, .cancelled = [&] { return ++asked > most; }});
    ended = asked <= most;
    CHECK(result.summary.termination == (ended ? Termination::stable : Termination::cancelled));
    CHECK(ownership_faults(problem, result.owners) == "");
  }
}

TEST_SUITE_END();
