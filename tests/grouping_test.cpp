#include "exact/grouping.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "parallel/arena.h"
#include "random.h"

using ccvt::Arena;
using ccvt::Grouping;
using ccvt::Index;

TEST_SUITE_BEGIN("assignment");

TEST_CASE("points are grouped by site, ascending, by any number of threads") {
  ccvt::Random random(3, 1);
  for (const std::size_t points : {0U, 1U, 7U, 1000U, 4001U}) {
    for (const std::size_t sites : {1U, 2U, 33U, 1000U, 5000U}) {
      CAPTURE(points);
      CAPTURE(sites);
      std::vector<Index> owners(points);
      // The last site owns nothing, if there are several.
      for (Index& owner : owners) {
        owner = random.index_below(static_cast<Index>(std::max<std::size_t>(1, sites - 1)));
      }
      std::vector<std::vector<std::size_t>> expected(sites);
      for (std::size_t p = 0; p < points; ++p) {
        expected[static_cast<std::size_t>(owners[p])].push_back(p);
      }
      for (const int threads : {1, 2, 3, 7}) {
        CAPTURE(threads);
        const Grouping groups(owners, sites, Arena(threads));
        REQUIRE(groups.count() == sites);
        std::size_t wrong = 0;
        for (const ccvt::SiteNumber s : ccvt::sites_below(sites)) {
          const auto members = groups.of(s);
          const auto& wanted = expected[s];
          wrong += std::ranges::equal(members, wanted, {}, [](auto p) { return std::size_t{p}; })
                       ? 0
                       : 1;
        }
        CHECK(wrong == 0);
      }
    }
  }
}

TEST_SUITE_END();
