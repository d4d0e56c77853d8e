#include <doctest/doctest.h>

#include <cstddef>
#include <string>
#include <vector>

#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/thread_ranks.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Problem;
using ccvt::test::messages_of;

TEST_SUITE_BEGIN("ranks");

TEST_CASE("ranks: different calls are told, on all") {
  const ccvt::Points<double> points = ccvt::sample_uniform<double>(Box::unit(2), 3000, 3);
  const std::vector<Index> owners = [] {
    std::vector<Index> made(3000);
    for (std::size_t p = 0; p < made.size(); ++p) made[p] = static_cast<Index>(p % 40);
    return made;
  }();
  for (const int count : {2, 3}) {
    for (const bool domain : {true, false}) {
      const auto call = [&](ccvt::Ranks& ranks) {
        Problem<double> problem(ranks, ccvt::view_points(points), 40);
        if (ranks.rank() == 1 && domain) problem.set_domain(Domain::periodic(Box::unit(2)));
        if (ranks.rank() == 1 && !domain) problem.set_initial_owners(owners);
        (void)ccvt::tessellate(problem, {.threads = 1});
      };
      for (const std::string& message : messages_of(count, call)) {
        CHECK(message.starts_with("ranks: have made different calls, such as "));
      }
    }
  }
}

TEST_CASE("ranks: of one there is a bounding box, too") {
  const ccvt::Points<double> points = ccvt::sample_uniform<double>(Box::unit(2), 30, 3);
  ThreadRanks(1).run([&](ccvt::Ranks& ranks) {
    const Problem<double> problem(ranks, ccvt::view_points(points), 4);
    CHECK(problem.box_of_ranks().lower == problem.bounding_box().lower);
    CHECK(problem.box_of_ranks().upper == problem.bounding_box().upper);
  });
}

TEST_SUITE_END();
