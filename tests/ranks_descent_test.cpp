// Levels of many points a site, by ranks that are threads here.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/impatient.h"
#include "support/thread_ranks.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Options;
using ccvt::Problem;
using ccvt::test::descents_of;
using ccvt::test::tessellate_impatiently;

namespace {

template <class Scalar>
struct Case {
  int dimension;
  Index points;
  Index sites;
  bool periodic = false;
  Options options = {};
  bool unequal = false;
  Index fixed_sites = 0;
  double patience = 0;

  void set_up(Problem<Scalar>& problem) const {
    const Box box = Box::unit(dimension);
    problem.set_domain(periodic ? Domain::periodic(box) : Domain::euclidean(box));
    if (unequal) {
      std::vector<Index> capacities(static_cast<std::size_t>(sites), 1);
      Index left = points - sites;
      for (std::size_t s = 0; s + 1 < capacities.size(); ++s) {
        const Index more = std::min(left, static_cast<Index>(s * s % 1500));
        capacities[s] += more;
        left -= more;
      }
      capacities.back() += left;
      problem.set_capacities(capacities);
    }
    if (fixed_sites > 0) {
      problem.set_fixed_sites(ccvt::sample_uniform<Scalar>(box, fixed_sites, 8));
    }
  }
};

template <class Scalar>
void compare(const Case<Scalar>& given) {
  CAPTURE(given.dimension);
  CAPTURE(given.points);
  const Box box = Box::unit(given.dimension);
  const ccvt::Points<Scalar> points = ccvt::sample_uniform<Scalar>(box, given.points, 3);
  Problem<Scalar> alone(points, given.sites);
  given.set_up(alone);
  Options options = given.options;
  options.threads = 1;
  const auto expected = tessellate_impatiently(alone, options, given.patience);
  if (given.patience > 0) CHECK(descents_of(expected.summary) > 1);
  for (const int count : {1, 2, 3, 7}) {
    CAPTURE(count);
    std::vector<Index> owners(expected.owners.size(), -1);
    std::vector<int> same(static_cast<std::size_t>(count), 0);
    ThreadRanks(count).run([&](ccvt::Ranks& ranks) {
      const auto place = [&](int rank) {
        return static_cast<Index>(std::int64_t{given.points} * rank / count);
      };
      const Index begin = place(ranks.rank());
      const auto own =
          ccvt::sample_uniform_part<Scalar>(box, given.points, begin, place(ranks.rank() + 1), 3);
      Problem<Scalar> problem(ranks, ccvt::view_points(own), given.sites);
      given.set_up(problem);
      Options theirs = given.options;
      theirs.threads = ranks.rank() % 2 + 1;
      const auto result = tessellate_impatiently(problem, theirs, given.patience);
      std::copy(result.owners.begin(), result.owners.end(), owners.begin() + begin);
      same[static_cast<std::size_t>(ranks.rank())] =
          result.sites == expected.sites && result.summary.energy == expected.summary.energy &&
                  result.summary.swaps == expected.summary.swaps &&
                  result.summary.iterations == expected.summary.iterations &&
                  result.summary.termination == expected.summary.termination
              ? 1
              : 0;
    });
    CHECK(owners == expected.owners);
    CHECK(std::count(same.begin(), same.end(), 1) == count);
  }
}

}  // namespace

TEST_SUITE_BEGIN("ranks");

TEST_CASE("ranks: many points a site have the bits of one process") {
  compare<float>({.dimension = 2, .points = 60'000, .sites = 100, .periodic = true});
  compare<double>({.dimension = 2, .points = 60'000, .sites = 20});  // descended to the end
  compare<float>({.dimension = 3, .points = 90'000, .sites = 120, .periodic = true});
  compare<float>({.dimension = 1, .points = 20'000, .sites = 30});
  // Cells of several blocks of points.
  compare<float>({.dimension = 2, .points = 120'000, .sites = 9});
}

TEST_CASE("ranks: many points a site, of unequal capacities, with sites that stay, to any end") {
  compare<double>({.dimension = 2, .points = 60'000, .sites = 80, .unequal = true});
  compare<float>(
      {.dimension = 2, .points = 60'000, .sites = 70, .periodic = true, .fixed_sites = 12});
  compare<float>({.dimension = 2,
                  .points = 60'000,
                  .sites = 60,
                  .periodic = true,
                  .options = {.until = ccvt::Until::blue_noise}});
  compare<float>({.dimension = 3, .points = 40'000, .sites = 16, .options = {.max_iterations = 4}});
  // Cells too large for their torus.
  compare<float>({.dimension = 2, .points = 9'000, .sites = 3, .periodic = true});
}

TEST_CASE("ranks: sites that descend again") {
  compare<double>({.dimension = 2, .points = 60'000, .sites = 20, .patience = 0.2});
  compare<float>({.dimension = 3,
                  .points = 40'000,
                  .sites = 80,
                  .periodic = true,
                  .options = {.descent_points = 50},
                  .patience = 0.2});
}

TEST_CASE("ranks: steps that are taken back") {
  // Points so few that the cells of a diagram, once they are full, are often not as good.
  for (const Index per_site : {6, 12, 25}) {
    compare<float>({.dimension = 2,
                    .points = 150 * per_site,
                    .sites = 150,
                    .periodic = true,
                    .options = {.descent_points = 1}});
    compare<double>(
        {.dimension = 3, .points = 150 * per_site, .sites = 150, .options = {.descent_points = 1}});
  }
}

TEST_SUITE_END();
