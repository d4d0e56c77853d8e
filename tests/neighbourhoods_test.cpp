#include "exact/neighbourhoods.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

#include "codebook/mergers.h"
#include "exact/pricing.h"
#include "exact/rivals.h"
#include "exact/site_groups.h"
#include "geometry/squares.h"
#include "random.h"

using ccvt::Arena;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::Neighbourhoods;
using ccvt::PointNumber;
using ccvt::Pricer;
using ccvt::Random;
using ccvt::SiteNumber;

namespace {

/// Clouds of unequal size, the last position twice; one after the other.
std::vector<double> clouds(std::size_t count, std::size_t dimension, std::uint64_t seed) {
  Random random(seed, 5);
  std::vector<double> positions(count * dimension);
  for (std::size_t k = 0; k + 1 < count; ++k) {
    const double cloud = 10 * static_cast<double>(k * k % 7);
    for (std::size_t d = 0; d < dimension; ++d) {
      positions[k * dimension + d] = cloud * static_cast<double>((d + k) % 2) + random.uniform();
    }
  }
  for (std::size_t d = 0; d < dimension && count > 1; ++d) {
    positions[(count - 1) * dimension + d] = positions[(count - 2) * dimension + d];
  }
  return positions;
}

ccvt::Points<double> as_points(const std::vector<double>& positions, int dimension) {
  return Eigen::Map<const Eigen::MatrixXd>(positions.data(), dimension,
                                           std::ssize(positions) / dimension);
}

}  // namespace

TEST_SUITE_BEGIN("codebook");

TEST_CASE("neighbourhoods: each position is in one group, and none is too large") {
  for (const std::size_t count : {1U, 2U, 3U, 64U, 1000U, 3000U}) {
    for (const std::size_t dimension : {1U, 2U, 16U}) {
      for (const std::size_t most : {1U, 10U, 5000U}) {
        CAPTURE(count);
        CAPTURE(dimension);
        CAPTURE(most);
        const std::vector<double> positions = clouds(count, dimension, 1);
        const Neighbourhoods near(positions, dimension, most, Arena(1));
        std::vector<int> times(count, 0);
        const std::vector<Index> groups = near.groups();
        for (std::size_t g = 0; g < near.count(); ++g) {
          CHECK(near.of(g).size() >= 1);
          CHECK(near.of(g).size() <= most);
          for (const SiteNumber s : near.of(g)) {
            ++times[s];
            CHECK(groups[s] == static_cast<Index>(g));
          }
        }
        CHECK(std::all_of(times.begin(), times.end(), [](int k) { return k == 1; }));
        CHECK(Neighbourhoods(positions, dimension, most, Arena(2)).order == near.order);
      }
    }
  }
}

TEST_CASE("neighbourhoods: clouds that lie apart are in groups of their own") {
  std::vector<double> positions;
  for (int k = 0; k < 40; ++k) positions.push_back((k % 4) * 100 + 0.01 * k);
  const Neighbourhoods near(positions, 1, 30, Arena(1));
  CHECK(near.count() >= 4);
  for (std::size_t g = 0; g < near.count(); ++g) {
    for (const SiteNumber s : near.of(g)) {
      CHECK(s.index() % 4 == near.of(g).front().index() % 4);
    }
  }
}

TEST_CASE_TEMPLATE("pricing of many sites with few points each finds what looking at all finds",
                   Scalar, float, double) {
  for (const int dimension : {2, 3, 5, 24}) {
    CAPTURE(dimension);
    const bool line = dimension == 3;  // of which each site would be a group of its own
    const std::size_t n = dimension == 5 ? 2100 : line ? 540 : 700;
    const auto width = static_cast<std::size_t>(dimension);
    std::vector<double> sites = clouds(n, width, 2);
    for (std::size_t k = 0; line && k < sites.size(); ++k) {
      sites[k] = 1e-2 * static_cast<double>(k / width);
    }
    const std::vector<double> many = clouds(5 * n, width, 3);
    const ccvt::Points<Scalar> points = as_points(many, dimension).template cast<Scalar>();
    Random random(4, 4);
    std::vector<double> weights(n);
    for (double& weight : weights) weight = 0.2 * random.uniform();
    weights[n - 1] = weights[n - 2];  // they are in one place, but along a line
    std::vector<Index> given(5 * n);
    for (Index& owner : given) owner = random.index_below(static_cast<Index>(n));
    const Metric metric(dimension, Domain());
    const auto reduced = [&](std::size_t p, Index owner) {
      const SiteNumber s(owner);
      return ccvt::squared_difference(points.col(static_cast<Index>(p)).data(),
                                      sites.data() + s * width, dimension) -
             weights[s];
    };
    double gap = 0;
    double energy = 0;
    std::vector<double> least(given.size(), std::numeric_limits<double>::infinity());
    for (std::size_t p = 0; p < given.size(); ++p) {
      for (Index s = 0; s < static_cast<Index>(n); ++s)
        least[p] = std::min(least[p], reduced(p, s));
      gap += reduced(p, given[p]) - least[p];
      energy += reduced(p, given[p]) + weights[SiteNumber(given[p])];
    }
    std::vector<std::vector<Index>> found;
    for (const int threads : {1, 3}) {
      const Arena arena(threads);
      const Pricer<Scalar> pricer(metric, ccvt::view_points(points), arena);
      std::vector<Index> owners = given;
      const ccvt::Prices prices = pricer.price({sites, weights}, owners);
      CHECK(prices.gap == doctest::Approx(gap).epsilon(1e-12));
      CHECK(prices.energy == doctest::Approx(energy).epsilon(1e-12));
      found.push_back(owners);
      found.push_back(pricer.cheapest({sites, weights}));
    }
    for (const auto& owners : found) {
      for (std::size_t p = 0; p < owners.size(); ++p) CHECK(reduced(p, owners[p]) == least[p]);
    }
    CHECK(found[0] == found[2]);
    CHECK(found[1] == found[3]);
  }
}

TEST_CASE("the cheapest merger of each cell, against all pairs") {
  for (const std::size_t dimension : {1U, 3U, 20U}) {
    const std::size_t n = 900;
    const std::vector<double> sites = clouds(n, dimension, 6);
    Random random(8, 8);
    std::vector<double> size(n);
    for (const double empty : {0.0, 0.05}) {
      for (double& count : size) {
        count = random.uniform() < empty ? 0 : 1 + std::floor(9 * random.uniform());
      }
      const auto found = ccvt::cheapest_mergers(sites, dimension, size, Arena(2));
      for (const SiteNumber i : ccvt::sites_below(n)) {
        ccvt::Merger best;
        for (const SiteNumber j : ccvt::sites_below(n)) {
          if (i == j) continue;
          const double sum = size[i] + size[j];
          const double share = size[i] * size[j] == 0 ? 0 : size[i] * size[j] / sum;
          const double cost = share * ccvt::squared_difference(sites.data() + i * dimension,
                                                               sites.data() + j * dimension,
                                                               static_cast<int>(dimension));
          if (cost < best.cost) best = {cost, i, j};
        }
        CHECK(found[i].i == i);
        CHECK(found[i].j == best.j);
        CHECK(found[i].cost == best.cost);
      }
    }
  }
  const std::vector<double> one = {1.0};
  CHECK(ccvt::cheapest_mergers(one, 1, one, Arena(1)).front().j == SiteNumber(0));
}

TEST_CASE("of very many sites, each is merged with one that is cheap") {
  constexpr std::size_t kDimension = 3;
  const std::size_t n = ccvt::kExactMergers + 100;
  const std::vector<double> sites = clouds(n, kDimension, 7);
  const std::vector<double> size(n, 2.0);
  const auto found = ccvt::cheapest_mergers(sites, kDimension, size, Arena(2));
  std::size_t cheapest = 0;
  std::size_t looked_at = 0;
  for (std::size_t k = 0; k < n; k += 20, ++looked_at) {
    const SiteNumber i(k);
    const auto cost_with = [&](SiteNumber j) {
      return ccvt::squared_difference(sites.data() + i * kDimension, sites.data() + j * kDimension,
                                      kDimension);
    };
    double least = std::numeric_limits<double>::infinity();
    for (const SiteNumber j : ccvt::sites_below(n)) {
      if (j != i) least = std::min(least, cost_with(j));
    }
    CHECK(found[i].i == i);
    CHECK(found[i].j != i);
    CHECK(found[i].cost == cost_with(found[i].j));  // two cells of two: a b / (a + b) is 1
    cheapest += found[i].cost == least ? 1 : 0;
  }
  CHECK(cheapest >= looked_at * 99 / 100);
}

TEST_CASE("rivals are all sites that cost some point less than its owner, and few others") {
  for (const int dimension : {1, 3, 20}) {
    CAPTURE(dimension);
    const std::size_t n = 400;
    const auto width = static_cast<std::size_t>(dimension);
    const std::vector<double> sites = clouds(n, width, 9);
    const std::vector<double> points = clouds(3 * n, width, 10);
    Random random(11, 4);
    std::vector<double> weights(n);
    for (double& weight : weights) weight = random.uniform();
    const ccvt::SiteGroups groups({sites, weights}, 16, Arena(1));
    const auto cost = [&](std::size_t p, SiteNumber s) {
      return ccvt::squared_difference(points.data() + p * width, sites.data() + s * width,
                                      dimension);
    };
    ccvt::Rivals rivals;
    std::size_t wanted = 0;
    std::size_t all = 0;
    for (std::size_t first = 0; first + 30 <= 3 * n; first += 30) {
      // The owners are the cheapest of some sites; every fifth point has a poor one.
      const double* const centre = points.data() + first * width;
      std::vector<SiteNumber> owner;
      rivals.clear();
      for (std::size_t p = first; p < first + 30; ++p) {
        SiteNumber best(random.index_below(static_cast<Index>(n)));
        for (std::size_t k = p % 3; p % 5 != 0 && k < n; k += 3) {
          const SiteNumber s(k);
          if (cost(p, s) - weights[s] < cost(p, best) - weights[best]) best = s;
        }
        owner.push_back(best);
        rivals.add(ccvt::squared_difference(points.data() + p * width, centre, dimension),
                   cost(p, best), weights[best]);
      }
      std::vector<int> found(n, 0);
      for (const auto& [s, squared] : rivals.find(groups, weights, centre, dimension)) {
        ++found[s];
        CHECK(squared == ccvt::squared_difference(centre, sites.data() + s * width, dimension));
      }
      for (const SiteNumber s : ccvt::sites_below(n)) {
        CHECK(found[s] <= 1);
        bool rival = false;
        for (std::size_t k = 0; k < owner.size(); ++k) {
          rival = rival ||
                  cost(first + k, s) - weights[s] <= cost(first + k, owner[k]) - weights[owner[k]];
        }
        if (rival) CHECK(found[s] == 1);
        wanted += rival ? 1 : 0;
        all += static_cast<std::size_t>(found[s]);
      }
    }
    CHECK(wanted > 0);
    if (dimension == 1) CHECK(all < 2 * wanted);
  }
}

TEST_SUITE_END();
