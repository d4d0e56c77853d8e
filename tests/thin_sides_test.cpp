// Clouds whose sides face apart, and equal counts on each.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <set>
#include <vector>

#include "ccvt/thin.h"
#include "parallel/arena.h"
#include "random.h"
#include "support/sheets.h"
#include "thin/lift.h"
#include "thin/sides.h"

using ccvt::Arena;
using ccvt::Index;
using ccvt::Points;
using ccvt::Side;
using ccvt::Thinning;
using ccvt::ThinOptions;
using ccvt::view_points;
using namespace ccvt::test;

namespace {

/// How far counts of sites differ at most that are on the same of the sheets.
Index spread_of_counts(const Sheets& sheets, const Thinning& thinning) {
  Index spread = 0;
  for (const bool upper : {false, true}) {
    std::vector<Index> counts;
    for (std::size_t s = 0; s < thinning.chosen.size(); ++s) {
      if ((sheets.points(2, thinning.chosen[s]) > 0) == upper) {
        counts.push_back(thinning.counts[s]);
      }
    }
    const auto [least, most] = std::minmax_element(counts.begin(), counts.end());
    spread = std::max(spread, *most - *least);
  }
  return spread;
}

/// Spheres of these radii, in turn a point of each.
Points<double> spheres(Index count, const std::vector<double>& radii) {
  ccvt::Random random(11);
  Points<double> points(3, count);
  for (Index p = 0; p < count; ++p) {
    for (double& x : points.col(p)) x = random.uniform() + random.uniform() - 1;
    points.col(p) *= radii[static_cast<std::size_t>(p) % radii.size()] / points.col(p).norm();
  }
  return points;
}

std::vector<Side> sides(const Points<double>& points, const Points<double>& normals,
                        const std::vector<Index>& chosen, int threads = 1) {
  const Arena arena(threads);
  const Points<double> lifted = ccvt::lift(view_points(points), view_points(normals), 0.05, arena);
  return ccvt::sides_of(view_points(lifted), chosen, arena);
}

}  // namespace

TEST_SUITE_BEGIN("thin");

TEST_CASE("equal counts differ by one on each of two sheets, and no point counts across") {
  for (const Index lower : {2, 11}) {
    const Sheets sheets(12000, lower);
    for (const Index sites : {60, 333, 1000}) {
      for (const double weight : {0.3, 0.5, 20.0}) {
        CAPTURE(lower);
        CAPTURE(sites);
        CAPTURE(weight);
        ThinOptions options;
        options.equal_counts = true;
        options.normal_weight = weight;
        const Thinning thinning = ccvt::thin(sheets.points, sites, options, sheets.normals);
        CHECK(spread_of_counts(sheets, thinning) <= 1);
        CHECK(sheets.across(thinning) == 0);
        CHECK(thinning.turned == 0);
      }
    }
  }
  // Without a move apart, too.
  const Sheets sheets(12000);
  ThinOptions options;
  options.equal_counts = true;
  options.spread = false;
  const Thinning thinning = ccvt::thin(sheets.points, 333, options, sheets.normals);
  CHECK(spread_of_counts(sheets, thinning) <= 1);
  CHECK(sheets.across(thinning) == 0);
}

TEST_CASE("out of time or cancelled, equal counts are those of all at once") {
  const Sheets sheets(40'000);
  ThinOptions options;
  options.equal_counts = true;
  for (const double limit : {1e-9, 0.02, 0.05}) {
    CAPTURE(limit);
    options.tessellation.time_limit = limit;
    const Thinning thinning = ccvt::thin(sheets.points, 2000, options, sheets.normals);
    CHECK(sheets.across(thinning) == 0);
    CHECK(std::accumulate(thinning.counts.begin(), thinning.counts.end(), 0) == 40'000);
  }
  options.tessellation.time_limit = 0;
  int asked = 0;
  options.tessellation.cancelled = [&] { return ++asked < 0; };
  ccvt::thin(sheets.points, 2000, options, sheets.normals);
  const int questions = asked;
  for (int at = 1; at <= questions; at += std::max(1, questions / 8)) {
    CAPTURE(at);
    asked = 0;
    options.tessellation.cancelled = [&] { return ++asked >= at; };
    const Thinning thinning = ccvt::thin(sheets.points, 2000, options, sheets.normals);
    if (thinning.summary.termination != ccvt::Termination::cancelled) continue;
    const auto [least, most] = std::minmax_element(thinning.counts.begin(), thinning.counts.end());
    CHECK(*least == 20);
    CHECK(*most == 20);
  }
}

TEST_CASE("sheets that face apart are sides, what is bent is one") {
  std::vector<Index> chosen;
  for (Index p = 0; p < 3000; p += 7) chosen.push_back(p);
  const Sheets sheets(3000);
  const std::vector<Side> two = sides(sheets.points, sheets.normals, chosen);
  REQUIRE(two.size() == 2);
  std::set<Index> all;
  for (const Side& side : two) {
    CHECK(std::is_sorted(side.points.begin(), side.points.end()));
    CHECK(std::is_sorted(side.sites.begin(), side.sites.end()));
    const double height = sheets.points(2, side.points.front());
    for (const Index p : side.points) CHECK(sheets.points(2, p) == height);
    for (const Index s : side.sites) {
      CHECK(sheets.points(2, chosen[static_cast<std::size_t>(s)]) == height);
    }
    all.insert(side.points.begin(), side.points.end());
  }
  CHECK(all.size() == 3000);
  CHECK(two[0].sites.size() + two[1].sites.size() == chosen.size());
  for (const int threads : {2, 3}) {
    const std::vector<Side> again = sides(sheets.points, sheets.normals, chosen, threads);
    REQUIRE(again.size() == 2);
    CHECK(again[0].points == two[0].points);
    CHECK(again[1].sites == two[1].sites);
  }

  const Points<double> sphere = spheres(3000, {1});
  CHECK(sides(sphere, sphere, chosen).size() == 1);
  const Points<double> shell = spheres(3000, {1, 0.95});
  Points<double> outward = shell;
  for (Index p = 1; p < 3000; p += 2) outward.col(p) *= -1;
  CHECK(sides(shell, outward, chosen).size() == 2);
  // Patches far apart that face alike are one, in a cloud with two sheets too.
  Points<double> patches = sheets.points;
  Points<double> up = sheets.normals;
  for (Index p = 0; p < 3000; ++p) {
    if (p % 3 == 0) continue;
    patches.col(p) += Eigen::Vector3d(10 * (1 + p % 5), 0, 0);
    up.col(p) << 0, 0, 1;
  }
  CHECK(sides(patches, up, chosen).size() == 3);
  CHECK(sides(patches, Points<double>::Constant(3, 3000, 1), chosen).size() == 1);
  // Of normals that are 0 nothing is known.
  CHECK(sides(shell, Points<double>::Zero(3, 3000), chosen).size() == 1);
}

TEST_SUITE_END();
