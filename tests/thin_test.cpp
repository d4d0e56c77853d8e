#include "ccvt/thin.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <set>
#include <string>
#include <vector>

#include "ccvt/solver.h"
#include "random.h"
#include "support/generate.h"
#include "support/message.h"
#include "support/sheets.h"
#include "thin/homes.h"
#include "thin/repulsion.h"

namespace ccvt::test {
namespace {

/// Evenly dense, but for chance, on the unit sphere.
Points<float> sphere(Index count, std::uint64_t seed) {
  Random random(seed);
  Points<float> points(3, count);
  for (Index p = 0; p < count; ++p) {
    const double z = 2 * random.uniform() - 1;
    const double turn = 8 * std::atan(1.0) * random.uniform();
    const double r = std::sqrt(1 - z * z);
    points.col(p) = Eigen::Vector3d(r * std::cos(turn), r * std::sin(turn), z).cast<float>();
  }
  return points;
}

/// What holds of any thinning: who is chosen, whose points are whose, and how many.
template <class Scalar>
void check_valid(const Points<Scalar>& points, Index sites, const Thinning& thinning) {
  REQUIRE(std::ssize(thinning.chosen) == sites);
  REQUIRE(std::ssize(thinning.owners) == points.cols());
  CHECK(std::is_sorted(thinning.chosen.begin(), thinning.chosen.end()));
  CHECK(std::adjacent_find(thinning.chosen.begin(), thinning.chosen.end()) ==
        thinning.chosen.end());
  std::vector<Index> counts(thinning.chosen.size(), 0);
  double energy = 0;
  for (std::size_t p = 0; p < thinning.owners.size(); ++p) {
    const auto owner = static_cast<std::size_t>(thinning.owners[p]);
    REQUIRE(owner < counts.size());
    ++counts[owner];
    energy += (points.col(static_cast<Index>(p)) - points.col(thinning.chosen[owner]))
                  .template cast<double>()
                  .squaredNorm();
  }
  CHECK(counts == thinning.counts);
  CHECK(energy == doctest::Approx(thinning.energy).epsilon(1e-5));
  for (std::size_t s = 0; s < counts.size(); ++s) {
    CHECK(thinning.owners[static_cast<std::size_t>(thinning.chosen[s])] == static_cast<Index>(s));
  }
}

void check_equal_counts(const Thinning& thinning) {
  const auto [least, most] = std::minmax_element(thinning.counts.begin(), thinning.counts.end());
  CHECK(*most - *least <= 1);
  CHECK(*least == static_cast<Index>(thinning.owners.size() / thinning.chosen.size()));
}

double smallest_distance(const Points<float>& points, const std::vector<Index>& chosen) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t a = 0; a < chosen.size(); ++a) {
    for (std::size_t b = a + 1; b < chosen.size(); ++b) {
      least = std::min(least, static_cast<double>(
                                  (points.col(chosen[a]) - points.col(chosen[b])).squaredNorm()));
    }
  }
  return std::sqrt(least);
}

ThinOptions equal_counts() {
  ThinOptions options;
  options.equal_counts = true;
  return options;
}

std::string refusal(const Points<double>& points, Index sites, const ThinOptions& options = {},
                    const Points<double>& normals = {}) {
  return message_of([&] {
    thin(view_points(points), sites, options,
         normals.size() > 0 ? view_points(normals) : PointsView<double>());
  });
}

}  // namespace

TEST_SUITE_BEGIN("thin");

TEST_CASE("every choice is of distinct points that own themselves, with equal counts") {
  for (const Layout layout : all_layouts) {
    CAPTURE(name_of(layout));
    for (const int dimension : {1, 2, 3, 5}) {
      CAPTURE(dimension);
      const auto points = make_points<float>(layout, uneven_box(dimension), 600);
      for (const Index sites : {1, 2, 70, 299, 301, 599, 600}) {
        CAPTURE(sites);
        const Thinning thinning = thin(points, sites, equal_counts());
        check_valid(points, sites, thinning);
        check_equal_counts(thinning);
        const Thinning nearest = thin(points, sites);
        check_valid(points, sites, nearest);
        CHECK(nearest.chosen == thinning.chosen);
        CHECK(nearest.energy <= thinning.energy);
      }
    }
  }
}

TEST_CASE("double, unequal sizes of cells, and many dimensions") {
  const auto points = make_points<double>(Layout::random, uneven_box(16), 500);
  const Thinning thinning = thin(points, 130, equal_counts());
  check_valid(points, 130, thinning);
  check_equal_counts(thinning);
}

TEST_CASE("counts of nearest points are those of the nearest points") {
  const auto points = make_points<double>(Layout::random, uneven_box(3), 2000);
  const Thinning thinning = thin(points, 300);
  check_valid(points, 300, thinning);
  for (Index p = 0; p < 2000; ++p) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const Index c : thinning.chosen) {
      nearest = std::min(nearest, (points.col(p) - points.col(c)).squaredNorm());
    }
    const Index owner = thinning.owners[static_cast<std::size_t>(p)];
    const Index chosen = thinning.chosen[static_cast<std::size_t>(owner)];
    CHECK((points.col(p) - points.col(chosen)).squaredNorm() == doctest::Approx(nearest));
  }
}

TEST_CASE("chosen points keep apart, at two points each as at fifty") {
  const auto points = sphere(4000, 3);
  struct Case {
    Index sites;
    double least;  ///< of the hexagonal spacing; sample elimination has .53, .67, .74, .80
  };
  for (const Case& test : {Case{2000, 0.47}, {1000, 0.6}, {400, 0.66}, {80, 0.7}}) {
    CAPTURE(test.sites);
    const double spacing = std::sqrt(32 * std::atan(1.0) / (std::sqrt(3.0) * test.sites));
    const Thinning thinning = thin(points, test.sites);
    CHECK(smallest_distance(points, thinning.chosen) / spacing > test.least);
    ThinOptions still;
    still.spread = false;
    const Thinning first = thin(points, test.sites, still);
    check_valid(points, test.sites, first);
    CHECK(smallest_distance(points, first.chosen) < smallest_distance(points, thinning.chosen));
    CHECK(thinning.spacing == doctest::Approx(spacing).epsilon(0.15));
  }
}

TEST_CASE("repulsion ends where no move to a point near, and no jump, lowers it by much") {
  const auto points = sphere(1500, 8);
  const Metric metric(3, Domain());
  for (const Index sites : {500, 100}) {
    CAPTURE(sites);
    const auto cells = tessellate(points, sites);
    const Arena arena(2);
    const Points<float> centres = cells.sites;
    const auto homes =
        make_homes(metric, view_points(points), cells.owners, view_points(centres), arena);
    std::vector<Place> first;
    for (const SiteNumber h : sites_below(sites)) first.push_back(*homes.places(h).begin());
    Repulsion<float> repulsion(homes, first, arena);
    const double before = repulsion.energy();
    REQUIRE(repulsion.run());
    CHECK(repulsion.energy() < 0.1 * before);
    // The slow way: what repels any place, from all chosen ones but one.
    const auto& chosen = repulsion.chosen();
    const auto repelled = [&](Place at, std::size_t without) {
      double sum = 0;
      for (std::size_t s = 0; s < chosen.size(); ++s) {
        if (s == without) continue;
        double squared = 0;
        for (int d = 0; d < 3; ++d) {
          const double difference =
              static_cast<double>(homes.at(at)[d]) - static_cast<double>(homes.at(chosen[s])[d]);
          squared += difference * difference;
        }
        const double reach = homes.reach_of(homes.home_of[at], homes.home_of[chosen[s]]);
        if (squared < reach * reach) sum += std::pow(1 - std::sqrt(squared) / reach, 8);
      }
      return sum;
    };
    double energy = 0;
    for (std::size_t s = 0; s < chosen.size(); ++s) {
      const double own = repelled(chosen[s], s);
      energy += own / 2;
      for (const Place place : homes.places(homes.home_of[chosen[s]])) {
        if (std::find(chosen.begin(), chosen.end(), place) != chosen.end()) continue;
        if (own > 1e-8) CHECK(repelled(place, s) > own * (1 - 1e-3));
      }
    }
    CHECK(energy == doctest::Approx(repulsion.energy()));
    CHECK(repulsion.quotas().worst_excess() == 0);
  }
}

TEST_CASE("energies that normals are a part of are not normalized") {
  const Sheets sheets(1000);
  const Summary with = thin(sheets.points, 100, {}, sheets.normals).summary;
  CHECK(with.normal_dimensions == 3);
  CHECK_FALSE(with.has_normalized_energy());
  CHECK(with.brief().find("energy") == std::string::npos);
  CHECK(with.full().find("n/a (not normalized: normals are dimensions)") != std::string::npos);
  const Summary without = thin(sheets.points, 100).summary;
  CHECK(without.has_normalized_energy());
  CHECK(without.brief().find("normalized energy") != std::string::npos);
}

TEST_CASE("reaches follow the density of the points, in the dimension that they spread over") {
  const Metric metric(3, Domain());
  const auto points = sphere(20000, 4);
  const auto cells = tessellate(points, 500);
  const Points<float> centres = cells.sites;
  const auto homes =
      make_homes(metric, view_points(points), cells.owners, view_points(centres), Arena(1));
  const double spacing = std::sqrt(32 * std::atan(1.0) / (std::sqrt(3.0) * 500));
  for (const double reach : homes.reach)
    CHECK(reach / spacing == doctest::Approx(0.97).epsilon(0.08));
}

TEST_CASE("no cell spans two sheets that face apart") {
  const Sheets sheets(4000);
  for (const Index sites : {80, 333, 1000}) {
    CAPTURE(sites);
    const Thinning thinning = thin(sheets.points, sites, {}, sheets.normals);
    check_valid(sheets.points, sites, thinning);
    CHECK(sheets.across(thinning) == 0);
    CHECK(sheets.across(thin(sheets.points, sites)) > 100);
    ThinOptions none;
    none.normal_weight = 0;
    CHECK(thin(sheets.points, sites, none, sheets.normals).owners ==
          thin(sheets.points, sites).owners);
    CHECK(sheets.across(thin(sheets.points, sites, equal_counts(), sheets.normals)) == 0);
  }
}

TEST_CASE("no cell spans two sheets of which one is many times as dense") {
  const Sheets sheets(20000, 11);
  for (const bool equal : {true, false}) {
    CAPTURE(equal);
    ThinOptions options;
    options.equal_counts = equal;
    const Thinning thinning = thin(sheets.points, 400, options, sheets.normals);
    check_valid(sheets.points, 400, thinning);
    CHECK(sheets.across(thinning) == 0);
  }
}

TEST_CASE("cancelled, it looks for no owners") {
  const Sheets sheets(4000);
  ThinOptions options;
  options.tessellation.cancelled = [] { return true; };
  for (const bool equal : {true, false}) {
    CAPTURE(equal);
    options.equal_counts = equal;
    const Thinning thinning = thin(sheets.points, 300, options, sheets.normals);
    CHECK(thinning.summary.termination == Termination::cancelled);
    CHECK(thinning.turned == 0);
    check_valid(sheets.points, 300, thinning);
    check_equal_counts(thinning);
  }
  // Out of time, owners are as they were asked for.
  options.equal_counts = false;
  options.tessellation.cancelled = nullptr;
  options.tessellation.time_limit = 1e-9;
  const Thinning late = thin(sheets.points, 300, options, sheets.normals);
  check_valid(sheets.points, 300, late);
  CHECK(sheets.across(late) == 0);
}

TEST_CASE("normals of length 0 are no directions, and lengths count for nothing") {
  Sheets sheets(1000);
  const Thinning before = thin(sheets.points, 100, {}, sheets.normals);
  const Points<double> longer = 1e200 * sheets.normals;
  CHECK(thin(sheets.points, 100, {}, longer).chosen == before.chosen);
  sheets.normals.setZero();
  check_valid(sheets.points, 100, thin(sheets.points, 100, {}, sheets.normals));
}

TEST_CASE("the same bits for any number of threads, and others for another seed") {
  const Sheets sheets(6000);
  ThinOptions options;
  options.tessellation.seed = 9;
  options.tessellation.threads = 1;
  const Thinning one = thin(sheets.points, 1300, options, sheets.normals);
  CHECK(one.moves > 0);
  CHECK(one.jumps > 0);
  for (const int threads : {2, 3}) {
    options.tessellation.threads = threads;
    const Thinning more = thin(sheets.points, 1300, options, sheets.normals);
    CHECK(more.chosen == one.chosen);
    CHECK(more.owners == one.owners);
    CHECK(more.energy == one.energy);
    CHECK(more.moves == one.moves);
  }
  options.tessellation.seed = 10;
  CHECK(thin(sheets.points, 1300, options, sheets.normals).chosen != one.chosen);
}

TEST_CASE("whenever it is cancelled, what has been reached is a choice") {
  const auto points = sphere(3000, 6);
  int asked = 0;
  ThinOptions options = equal_counts();
  options.tessellation.cancelled = [&] { return ++asked < 0; };
  const Thinning whole = thin(points, 1000, options);
  CHECK(whole.summary.termination != Termination::cancelled);
  const int questions = asked;
  REQUIRE(questions > 2);
  bool any = false;
  for (int at = 1; at <= questions; at += std::max(1, questions / 12)) {
    CAPTURE(at);
    asked = 0;
    options.tessellation.cancelled = [&] { return ++asked >= at; };
    const Thinning thinning = thin(points, 1000, options);
    check_valid(points, 1000, thinning);
    check_equal_counts(thinning);
    any = any || thinning.summary.termination == Termination::cancelled;
  }
  CHECK(any);
  options.tessellation.cancelled = nullptr;
  options.tessellation.time_limit = 1e-9;
  const Thinning late = thin(points, 1000, options);
  check_valid(points, 1000, late);
  CHECK(late.summary.termination == Termination::time_limit);
}

TEST_CASE("bad input is refused in one line") {
  const auto points = make_points<double>(Layout::random, uneven_box(3), 10);
  CHECK(refusal(points, 11) ==
        "sites: 11 for 10 points: there must be at least one site, and no more sites than points");
  ThinOptions options;
  options.normal_weight = -1;
  CHECK(refusal(points, 2, options) == "normal_weight: is -1; must be from 0 to 100");
  options.normal_weight = std::numeric_limits<double>::quiet_NaN();
  CHECK(refusal(points, 2, options) == "normal_weight: is nan; must be from 0 to 100");
  options.normal_weight = 1e308;
  CHECK(refusal(points, 2, options, Points<double>::Ones(3, 10)) ==
        "normal_weight: is 1e+308; must be from 0 to 100");
  options = {};
  options.tessellation.threads = -1;
  CHECK(refusal(points, 2, options).find("Options::threads is -1") == 0);
  CHECK(refusal(points, 2, {}, Points<double>::Zero(3, 9)) ==
        "normals: there are 9 of 3 dimensions, for 10 points of 3; needs one a point, of as many "
        "dimensions");
  Points<double> normals = Points<double>::Ones(3, 10);
  normals(1, 7) = std::numeric_limits<double>::infinity();
  normals(0, 8) = std::numeric_limits<double>::infinity();
  CHECK(refusal(points, 2, {}, normals) ==
        "normals: normal 7 has the coordinate inf in dimension 1; coordinates must be finite");
}

TEST_SUITE_END();

}  // namespace ccvt::test
