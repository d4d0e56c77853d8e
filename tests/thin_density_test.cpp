#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "ccvt/solver.h"
#include "ccvt/thin.h"
#include "random.h"
#include "thin/quotas.h"

namespace ccvt::test {
namespace {

/// Of 2-D points those whose figure is within each pair of borders, and those chosen there.
struct Bins {
  std::vector<double> expected;
  std::vector<double> chosen;

  template <class Figure>
  Bins(const Points<double>& points, const Thinning& thinning, const std::vector<double>& borders,
       const Figure& figure)
      : expected(borders.size() - 1), chosen(expected) {
    const auto bin = [&](Index p) -> std::size_t {
      const auto above =
          std::upper_bound(borders.begin() + 1, borders.end() - 1, figure(points.col(p)));
      return static_cast<std::size_t>(above - borders.begin() - 1);
    };
    const double share =
        static_cast<double>(thinning.chosen.size()) / static_cast<double>(points.cols());
    for (Index p = 0; p < points.cols(); ++p) expected[bin(p)] += share;
    for (const Index c : thinning.chosen) chosen[bin(c)] += 1;
  }
  void check() const {
    for (std::size_t b = 0; b < expected.size(); ++b) {
      CAPTURE(b);
      CAPTURE(expected[b]);
      CAPTURE(chosen[b]);
      CHECK(std::abs(chosen[b] - expected[b]) < 0.15 * expected[b] + 2 * std::sqrt(expected[b]));
    }
  }
};

}  // namespace

TEST_SUITE_BEGIN("thin");

TEST_CASE("quotas let choices move within chance, and less where the density changes") {
  // Of 64 homes with four points each, blocks of 8 may miss their homes by 4, those of 32 by 8.
  Quotas even(std::vector<double>(64, 1.0), 4);
  for (const SiteNumber h : sites_below(64)) even.enter(h);
  const auto move = [](Quotas& quotas, std::size_t from, std::size_t to) {
    if (!quotas.allow(SiteNumber(from), SiteNumber(to))) return false;
    quotas.leave(SiteNumber(from));
    quotas.enter(SiteNumber(to));
    return true;
  };
  for (int k = 0; k < 4; ++k) CHECK(move(even, 0, 8));
  CHECK_FALSE(move(even, 1, 16));  // the first has lost what it may
  CHECK_FALSE(move(even, 17, 9));  // the second has gained it
  CHECK(move(even, 7, 3));
  CHECK(move(even, 9, 1));
  CHECK(move(even, 9, 17));
  CHECK(even.worst_excess() == 0);
  even.leave(SiteNumber(20));
  for (int k = 0; k < 9; ++k) even.enter(SiteNumber(40 + 8 * (k % 2)));
  CHECK(even.worst_excess() == 1);
  // The same where reaches differ: by one.
  std::vector<double> reach(64, 1.0);
  for (std::size_t h = 0; h < 64; h += 8) reach[h] = 2;
  Quotas steep(reach, 4);
  for (const SiteNumber h : sites_below(64)) steep.enter(h);
  CHECK(move(steep, 0, 8));
  CHECK_FALSE(move(steep, 1, 16));
  CHECK_FALSE(move(steep, 17, 9));
  CHECK(steep.worst_excess() == 0);
}

TEST_CASE("choices are as dense as the cloud, where that changes steeply too") {
  constexpr Index count = 30'000;
  const double turn = 8 * std::atan(1.0);
  Random random(1);
  Points<double> edge(2, count);
  Points<double> cluster(2, count);
  Points<double> slope(2, count);
  for (Index p = 0; p < count; ++p) {
    const double u = random.uniform();
    edge.col(p) << u * u, random.uniform();
    const double r = 0.1 * std::sqrt(-2 * std::log(1 - random.uniform()));
    const double angle = turn * random.uniform();
    cluster.col(p) << r * std::cos(angle), r * std::sin(angle);
    if (p % 2 == 0) cluster.col(p) << 4 * random.uniform() - 2, 4 * random.uniform() - 2;
    do {
      slope.col(p) << random.uniform(), random.uniform();
    } while (random.uniform() > (1 + 8 * slope(0, p)) / 9);
  }
  const auto x = [](const auto& at) { return at(0); };
  const auto radius = [](const auto& at) { return at.norm(); };
  for (const Index sites : {count / 4, count / 20}) {
    CAPTURE(sites);
    const Thinning dense = thin(cluster, sites);
    Bins(cluster, dense, {0, .05, .1, .15, .2, .25, .3, .4, .6, 1, 3}, radius).check();
    // The nearest are near.
    const double cells = tessellate(cluster, sites).summary.energy;
    CHECK(dense.energy < 2.5 * cells);
    Bins(slope, thin(slope, sites), {0, .1, .2, .3, .4, .5, .6, .7, .8, .9, 1}, x).check();
    // Where the first bin is as wide as choices are apart, which is the least that they can tell.
    Bins(edge, thin(edge, sites), {0, .02, .04, .1, .3, .6, 1}, x).check();
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
