// Owners for the start of balanced codebooks.
#include "codebook/dealing.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/sampling.h"
#include "cell_sizes.h"
#include "geometry/squares.h"
#include "random.h"

namespace ccvt::test {
namespace {

std::vector<double> draw_sites(int dimension, Index count) {
  Random random(8, 3);
  std::vector<double> sites(static_cast<std::size_t>(dimension * count));
  for (double& x : sites) x = random.uniform();
  return sites;
}

/// Round by round, then point by point.
std::vector<Index> deal_slowly(const Points<float>& points, const std::vector<double>& sites,
                               std::vector<Index> room) {
  const auto dimension = static_cast<int>(points.rows());
  std::vector<Index> owners(static_cast<std::size_t>(points.cols()), -1);
  const auto squared = [&](Index p, std::size_t s) {
    return squared_difference(points.col(p).data(),
                              sites.data() + s * static_cast<std::size_t>(dimension), dimension);
  };
  const auto nearest_open = [&](Index p) {
    std::size_t nearest = room.size();
    for (std::size_t s = 0; s < room.size(); ++s) {
      if (room[s] == 0) continue;
      if (nearest == room.size() || squared(p, s) < squared(p, nearest)) nearest = s;
    }
    return nearest;
  };
  const auto left = [&] { return std::count(owners.begin(), owners.end(), -1); };
  for (bool rounds = true; left() > 0;) {
    const auto before = left();
    std::vector<std::vector<std::pair<double, Index>>> wishes(room.size());
    for (Index p = 0; p < points.cols(); ++p) {
      if (owners[static_cast<std::size_t>(p)] >= 0) continue;
      const std::size_t nearest = nearest_open(p);
      if (rounds) {
        wishes[nearest].emplace_back(squared(p, nearest), p);
      } else {
        owners[static_cast<std::size_t>(p)] = static_cast<Index>(nearest);
        --room[nearest];
      }
    }
    for (std::size_t s = 0; s < room.size(); ++s) {
      std::sort(wishes[s].begin(), wishes[s].end());
      for (const auto& [cost, p] : wishes[s]) {
        if (room[s] == 0) break;
        owners[static_cast<std::size_t>(p)] = static_cast<Index>(s);
        --room[s];
      }
    }
    rounds = before - left() >= before / 4;
  }
  return owners;
}

}  // namespace

TEST_SUITE_BEGIN("codebook");

TEST_CASE("dealing: round by round to the nearest sites with room, for any number of threads") {
  for (const int dimension : {2, 9, 40}) {
    CAPTURE(dimension);
    const auto points = sample_uniform<float>(Box::unit(dimension), 3001, 5, Distribution::white);
    const std::vector<double> sites = draw_sites(dimension, 70);
    std::vector<Index> capacities = equal_capacities(3001, 70);
    capacities[3] -= 20;
    capacities[9] += 20;
    const auto expected = deal_slowly(points, sites, capacities);
    CHECK(cell_sizes(expected, 70) == capacities);
    for (const int threads : {1, 3}) {
      CHECK(deal_to_nearest(view_points(points), sites, capacities, Arena(threads)) == expected);
    }
  }
}

TEST_CASE("dealing: capacities are kept where nearly all want the same sites") {
  // All sites lie on a line away from the points: each round fills one.
  const auto points = sample_uniform<float>(Box::unit(9), 2000, 6, Distribution::white);
  std::vector<double> sites(std::size_t{9} * 100, 0.5);
  for (std::size_t s = 0; s < 100; ++s) sites[9 * s] = 2 + 0.1 * static_cast<double>(s);
  const std::vector<Index> capacities = equal_capacities(2000, 100);
  const auto owners = deal_to_nearest(view_points(points), sites, capacities, Arena(2));
  CHECK(cell_sizes(owners, 100) == capacities);
  CHECK(owners == deal_to_nearest(view_points(points), sites, capacities, Arena(1)));
  const std::vector<Index> all(1, 2000);
  const std::vector<double> one(sites.begin(), sites.begin() + 9);
  CHECK(deal_to_nearest(view_points(points), one, all, Arena(1)) == std::vector<Index>(2000, 0));
}

TEST_SUITE_END();

}  // namespace ccvt::test
