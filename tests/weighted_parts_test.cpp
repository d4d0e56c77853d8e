// What tessellate_masses() is made of.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "compensated_sum.h"
#include "random.h"
#include "support/generate.h"
#include "support/processor_time.h"
#include "weighted/curve_order.h"
#include "weighted/units.h"
#include "weighted/whole.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Index;
using ccvt::PointNumber;
using ccvt::Points;
using ccvt::SiteNumber;
using namespace ccvt::test;

namespace {

std::vector<PointNumber> numbers(Index count) {
  std::vector<PointNumber> all;
  for (const PointNumber p : ccvt::points_below(count)) all.push_back(p);
  return all;
}

double length_of(const Points<double>& points, const std::vector<PointNumber>& order) {
  double length = 0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    length += (points.col(order[k].index()) - points.col(order[k - 1].index())).norm();
  }
  return length;
}

}  // namespace

TEST_SUITE_BEGIN("weighted parts");

TEST_CASE("the curve goes through all points, and from neighbour to neighbour") {
  const Arena arena(1);
  for (const int dimension : {1, 2, 3, 8, 40}) {
    for (const Layout layout : all_layouts) {
      const auto points = make_points<double>(layout, uneven_box(dimension), 3000);
      const auto order = ccvt::curve_order(ccvt::view_points(points), numbers(3000), arena);
      auto sorted = order;
      std::sort(sorted.begin(), sorted.end());
      CAPTURE(dimension);
      CAPTURE(name_of(layout));
      CHECK(sorted == numbers(3000));
      // The others are given along a line, or have hardly any places.
      const bool spread = layout == Layout::random || layout == Layout::clusters;
      if (dimension > 3 || !spread) continue;
      // A curve through n points in the unit cube is about n^(1 - 1/D) long, not n.
      CHECK(length_of(points, order) < 0.3 * length_of(points, numbers(3000)) + 1e-9);
    }
  }
}

TEST_CASE("the curve is as good inside a crowd far from the rest") {
  const Arena arena(1);
  auto points = make_points<double>(Layout::random, Box::unit(2), 4000);
  points.rightCols(3000) *= 1e-7;
  const auto order = ccvt::curve_order(ccvt::view_points(points), numbers(4000), arena);
  std::vector<PointNumber> crowd;
  for (const PointNumber p : order) {
    if (p.index() >= 1000) crowd.push_back(p);
  }
  std::vector<PointNumber> any = crowd;
  std::sort(any.begin(), any.end());
  CHECK(length_of(points, crowd) < 0.1 * length_of(points, any));
}

TEST_CASE("units: every stretch of the curve has its mass in units, to within one") {
  ccvt::Random random(3);
  for (const Index count : {1, 7, 1000, 20000}) {
    std::vector<double> masses;
    ccvt::CompensatedSum total;
    for (int p = 0; p < 500; ++p) {
      masses.push_back(std::pow(random.uniform() + 1e-9, -2));
      total.add(masses.back());
    }
    auto order = numbers(500);
    random.shuffle(std::span(order));
    const auto units = ccvt::units_along(order, masses, total.value(), count, 5);
    REQUIRE(units.size() == static_cast<std::size_t>(count));
    std::vector<double> held(500, 0);
    for (const PointNumber p : units) ++held[p];
    std::vector<double> ahead(1, 0);  // of each prefix: units less mass in units
    for (const PointNumber p : order) {
      ahead.push_back(ahead.back() + held[p] - masses[p] * count / total.value());
    }
    const auto [low, high] = std::minmax_element(ahead.begin(), ahead.end());
    CHECK(*high - *low <= 1 + 1e-7);
    CHECK(ccvt::units_along(order, masses, total.value(), count, 5) == units);
    CHECK((count == 1 || ccvt::units_along(order, masses, total.value(), count, 6) != units));
  }
}

TEST_CASE("capacities in units: rounded, none without, and their sum") {
  const auto check = [](const std::vector<double>& capacities, Index count, bool small) {
    const auto units = ccvt::capacities_in_units(capacities, count);
    CHECK(std::accumulate(units.begin(), units.end(), Index{0}) == count);
    CHECK(*std::min_element(units.begin(), units.end()) >= 1);
    const double total = std::accumulate(capacities.begin(), capacities.end(), 0.0);
    for (std::size_t s = 0; s < units.size() && !small; ++s) {
      CHECK(std::abs(units[s] - capacities[s] * count / total) <= 1 + 1e-9);
    }
  };
  check({1, 1, 1}, 7, false);
  check({0.1, 0.2, 0.7}, 1000, false);
  check({1e-9, 1, 1e-9, 5}, 20, true);
  check(std::vector<double>(50, 0.3), 50, false);
  std::vector<double> steep;
  for (int s = 0; s < 60; ++s) steep.push_back(std::exp2(-s));
  check(steep, 60, true);
  check(steep, 600, true);
}

TEST_CASE("owners of units: the most first, of equally many the lower number") {
  std::vector<ccvt::UnitOwner> counted;
  ccvt::count_owners(std::vector<Index>{4, 2, 9, 2, 9, 7}, counted);
  std::vector<Index> sites;
  for (const auto& owner : counted) sites.push_back(owner.site);
  CHECK(sites == std::vector<Index>{2, 9, 4, 7});
  CHECK(counted[0].units == 2);
  CHECK(counted[2].units == 1);
}

TEST_CASE("balancing keeps the bound from whatever owners, also with cells without points") {
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    ccvt::Random random(seed, 11);
    const int dimension = 1 + random.index_below(4);
    const Index sites = 2 + random.index_below(30);
    const Index count = sites * (1 + random.index_below(6));
    const Box box = uneven_box(dimension);
    const ccvt::Metric metric(
        dimension, seed % 2 == 0 ? ccvt::Domain::periodic(box) : ccvt::Domain::euclidean(box));
    const auto points = make_points<float>(all_layouts[seed % 3], box, count, seed);
    std::vector<double> masses(static_cast<std::size_t>(count), 1.0);
    if (seed % 3 != 0) {
      for (double& mass : masses) mass = std::pow(1 - random.uniform(), -0.7);
    }
    for (int turn = 0; turn < 200; ++turn) {
      const double sum = std::accumulate(masses.begin(), masses.end(), 0.0);
      for (double& mass : masses) mass = std::min(mass, sum / sites * (1 - 1e-13));
    }
    if (*std::max_element(masses.begin(), masses.end()) * sites >
        std::accumulate(masses.begin(), masses.end(), 0.0)) {
      masses.assign(masses.size(), 1.0);  // as with a point a site
    }
    const double total = std::accumulate(masses.begin(), masses.end(), 0.0);
    const std::vector<double> capacities(static_cast<std::size_t>(sites), total / sites);
    std::vector<Index> owners(static_cast<std::size_t>(count), 0);
    for (Index& owner : owners) {
      if (seed % 4 == 1) owner = sites - 1;
      if (seed % 4 == 2) owner = random.index_below(sites);
      if (seed % 4 == 3) owner = random.index_below(std::max(1, sites / 3));
    }
    ccvt::SiteState state(dimension, sites);
    for (const SiteNumber s : state.all()) {
      for (int d = 0; d < dimension; ++d) {
        state.at(s)[d] =
            metric.into_box(box.lower[d] + random.uniform() * (box.upper[d] - box.lower[d]), d);
      }
    }
    ccvt::Stop stop;
    const Arena arena(1, &stop);
    ccvt::MassCells<float> cells(metric, ccvt::view_points(points), masses, capacities, owners,
                                 state, 10, arena);
    ccvt::WholePoints<float> whole(cells, arena, stop);
    whole.balance();
    CAPTURE(seed);
    const double heaviest = *std::max_element(masses.begin(), masses.end());
    double held = 0;
    std::size_t members = 0;
    for (const SiteNumber s : state.all()) {
      CHECK(std::abs(cells.error(s)) < heaviest);
      CHECK(!cells.members(s).empty());
      held += cells.held(s);
      members += cells.members(s).size();
    }
    CHECK(held == doctest::Approx(total).epsilon(1e-12));
    CHECK(members == masses.size());
    if (seed % 3 == 0) {  // equal masses that divide
      for (const SiteNumber s : state.all()) CHECK(std::abs(cells.error(s)) < 1e-9);
    }
    // And sweeps keep it, while the energy falls.
    double before = whole.energy();
    for (int sweep = 0; sweep < 200 && whole.sweep().swaps > 0; ++sweep) {
      CHECK(whole.energy() <= before * (1 + 1e-12));
      before = whole.energy();
    }
    CHECK(whole.sweep().swaps == 0);
    for (const SiteNumber s : state.all()) CHECK(std::abs(cells.error(s)) < heaviest);
  }
}

TEST_CASE("a run that is to stop balances no more than the bound needs") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 2000);
  ccvt::Random random(4);
  std::vector<double> masses;
  for (int p = 0; p < 2000; ++p) masses.push_back(0.5 + random.uniform());
  const double total = std::accumulate(masses.begin(), masses.end(), 0.0);
  const std::vector<double> capacities(20, total / 20);
  std::vector<Index> owners;
  for (Index p = 0; p < 2000; ++p)
    owners.push_back(std::min(19, static_cast<Index>(20 * points(0, p))));
  const ccvt::Metric metric(2, {});
  const auto error_left = [&](bool stopped) {
    ccvt::Stop stop(stopped ? [] { return true; } : std::function<bool()>{});
    const Arena arena(1, &stop);
    ccvt::MassCells<double> cells(metric, ccvt::view_points(points), masses, capacities, owners,
                                  ccvt::SiteState(2, 20), 10, Arena(1));
    ccvt::WholePoints<double> whole(cells, arena, stop);
    whole.balance();
    double all = 0;
    for (const SiteNumber s : cells.sites().all()) {
      CHECK(std::abs(cells.error(s)) < cells.heaviest());
      all += std::abs(cells.error(s));
    }
    return all;
  };
  CHECK(error_left(false) < error_left(true));
}

TEST_CASE("a cell that has no room left for errors: rounding takes no more from it than there is") {
  // Cell 1 is too heavy by more than the bound, so that cell 0 may lose nothing by a cut.
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    ccvt::Random random(seed);
    constexpr Index count = 400;
    Points<double> points(2, count);
    std::vector<double> masses;
    std::vector<Index> owners;
    for (Index p = 0; p < count; ++p) {
      const bool first = p < count / 2;
      points.col(p) << (first || p == 399 ? -1 : 1) + 0.5 * random.uniform(), random.uniform();
      masses.push_back(random.uniform());
      owners.push_back(first || p == 399 ? 0 : 1);
    }
    points(0, 0) = 1;  // of cell 0, and so there is something to do
    const std::vector<double> capacities{200, 5};
    const ccvt::Metric metric(2, {});
    ccvt::MassCells<double> cells(metric, ccvt::view_points(points), masses, capacities, owners,
                                  ccvt::SiteState(2, 2), 10, Arena(1));
    ccvt::MassPair<double> pair;
    pair.improve(cells, SiteNumber(0), SiteNumber(1));
    CHECK(cells.members(SiteNumber(0)).size() + cells.members(SiteNumber(1)).size() == count);
  }
}

TEST_CASE("points that move from a cell to another stay in order, and go soon") {
  constexpr Index kCount = 100000;
  ccvt::Random random(7);
  const Points<double> points = Points<double>::Random(3, kCount);
  std::vector<double> masses;
  for (Index p = 0; p < kCount; ++p) masses.push_back(1 + random.index_below(5));
  const std::vector<Index> owners(kCount, 0);
  const std::vector<double> capacities{1, 1};
  const ccvt::Metric metric(3, {});
  const auto make = [&] {
    return ccvt::MassCells<double>(metric, ccvt::view_points(points), masses, capacities, owners,
                                   ccvt::SiteState(3, 2), 10, Arena(1));
  };
  const std::array<SiteNumber, 2> both = {SiteNumber(0), SiteNumber(1)};
  auto cells = make();
  const double start = ccvt::test::processor_seconds();
  for (int k = 0; k < 1500; ++k) {
    const bool back = k % 3 == 2;
    const auto members = cells.members(both[back ? 1 : 0]);
    const auto count = static_cast<Index>(members.size());
    const PointNumber moved = members[static_cast<std::size_t>(random.index_below(count))];
    cells.move(moved, both[back ? 1 : 0], both[back ? 0 : 1]);
  }
  CHECK(ccvt::test::processor_seconds() - start < 2);
  auto expected = make();
  for (const SiteNumber s : both) {
    const auto members = cells.members(s);
    REQUIRE(members.size() == (s == both[1] ? 500 : kCount - 500));
    expected.set_members(s, {members.begin(), members.end()});
    CHECK(std::ranges::equal(members, expected.members(s)));
    CHECK(std::ranges::equal(cells.masses(s), expected.masses(s)));
    CHECK(std::equal(cells.block(s), cells.block(s) + 3 * members.size(), expected.block(s)));
    CHECK(cells.held(s) == expected.held(s));
  }
}

TEST_SUITE_END();
