// What follows points from one position of the sites to the next, against a look at all.
#include "relax/owner_bounds.h"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cell_sizes.h"
#include "parallel/arena.h"
#include "random.h"
#include "relax/cells.h"
#include "relax/moving_cells.h"
#include "relax/update.h"
#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Cells;
using ccvt::CompensatedSum;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::MovingCells;
using ccvt::OwnerBounds;
using ccvt::OwnerChange;
using ccvt::PointNumber;
using ccvt::PointOfAll;
using ccvt::Points;
using ccvt::points_below;
using ccvt::PointsView;
using ccvt::Random;
using ccvt::SiteNumber;
using ccvt::SiteState;
using namespace ccvt::test;

namespace {

template <class Scalar>
struct Owned {
  Metric metric;
  const Points<Scalar>& points;
  SiteState sites;
  std::vector<Index> owners;

  Owned(const Points<Scalar>& all, const Box& box, Index count, bool periodic)
      : metric(static_cast<int>(all.rows()), periodic ? Domain::periodic(box) : Domain()),
        points(all),
        sites(all.rows(), count),
        owners(static_cast<std::size_t>(all.cols()), 0) {
    for (const SiteNumber s : sites.all()) {
      for (Index d = 0; d < points.rows(); ++d) {
        sites.at(s)[d] = points(d, s.index() * (points.cols() / count));
      }
    }
    bound_radii();
  }

  [[nodiscard]] double squared(PointNumber p, SiteNumber s) const {
    return metric.squared_distance(points.col(p.index()).data(), sites.at(s));
  }
  [[nodiscard]] double squared(PointNumber p) const { return squared(p, SiteNumber(owners[p])); }

  void bound_radii() {
    std::fill(sites.radius.begin(), sites.radius.end(), 0.0);
    for (const PointNumber p : points_below(owners.size())) {
      double& radius = sites.radius[SiteNumber(owners[p])];
      radius = std::max(radius, std::sqrt(squared(p)) * (1 + 1e-12));
    }
  }
  void move_sites(const Box& box, double far, Random& random) {
    for (const SiteNumber s : sites.all()) {
      if (random.below(3) == 0) continue;
      for (Index d = 0; d < points.rows(); ++d) {
        const double shift = far * (random.uniform() - 0.5) * box.extent()[d];
        sites.at(s)[d] = metric.into_box(sites.at(s)[d] + shift, d);
      }
    }
    bound_radii();
  }
};

/// Where `all` are not the points that have a nearer site than their owner, and the nearest.
template <class Scalar, class Changes>
std::string faults(const Owned<Scalar>& owned, const Changes& all, double margin) {
  std::string wrong;
  std::vector<SiteNumber> to(owned.owners.size(), SiteNumber::none());
  for (const OwnerChange& change : all) to[change.point] = change.to;
  for (const PointNumber p : points_below(owned.owners.size())) {
    double nearest = std::numeric_limits<double>::infinity();
    for (const SiteNumber s : owned.sites.all()) nearest = std::min(nearest, owned.squared(p, s));
    const double own = owned.squared(p);
    const double doubt = 1e-12 * own;
    const bool must = own - nearest > margin + doubt;
    const bool may = own - nearest > margin - doubt;
    const bool does = to[p] != SiteNumber::none();
    if ((does && !may) || (must && !does) || (does && owned.squared(p, to[p]) > nearest + doubt)) {
      wrong += " point " + std::to_string(p.index());
    }
  }
  return wrong;
}

}  // namespace

TEST_SUITE_BEGIN("lloyd");

TEST_CASE_TEMPLATE("leads find all points with a nearer site", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 11}) {
    for (const bool periodic : {false, true}) {
      for (const Layout layout : {Layout::random, Layout::clusters, Layout::duplicates}) {
        for (const Index sites : {1, 2, 12, 70}) {
          CAPTURE(dimension);
          CAPTURE(periodic);
          CAPTURE(name_of(layout));
          CAPTURE(sites);
          const Box box = uneven_box(dimension);
          const auto points = make_points<Scalar>(layout, box, 1200);
          Owned<Scalar> owned(points, box, sites, periodic);
          const Arena arena(2);
          const PointsView<Scalar> view = ccvt::view_points(points);
          OwnerBounds<Scalar> bounds(owned.metric, view, arena);
          Random random(7);
          for (int iteration = 0; iteration < 30; ++iteration) {
            CAPTURE(iteration);
            const double margin = iteration % 3 == 2 ? 1e-3 : 0;
            const auto all = bounds.changes(owned.sites, owned.owners, margin);
            CHECK(faults(owned, all, margin) == "");
            for (const OwnerChange& change : all) owned.owners[change.point] = change.to.index();
            // Far, then nearer and nearer; once all stay, and once they jump.
            const double far = iteration == 20 ? 1 : iteration == 9 ? 0 : std::pow(0.7, iteration);
            owned.move_sites(box, far, random);
          }
        }
      }
    }
  }
}

TEST_CASE("what was too far to be listed comes near") {
  // Every tenth site crosses the square, while no radius tells that anything has changed.
  const Box box = Box::unit(2);
  const auto points = make_points<double>(Layout::random, box, 4000);
  Owned<double> owned(points, box, 400, true);
  const Arena arena(1);
  const PointsView<double> view = ccvt::view_points(points);
  for (const OwnerChange& change :
       OwnerBounds<double>(owned.metric, view, arena).changes(owned.sites, owned.owners, 0)) {
    owned.owners[change.point] = change.to.index();
  }
  OwnerBounds<double> bounds(owned.metric, view, arena);
  for (int iteration = 0; iteration < 60; ++iteration) {
    owned.bound_radii();
    for (double& radius : owned.sites.radius) {
      REQUIRE(radius < 0.1);
      radius = 0.1;
    }
    CAPTURE(iteration);
    const auto all = bounds.changes(owned.sites, owned.owners, 0);
    CHECK(faults(owned, all, 0) == "");
    for (const OwnerChange& change : all) owned.owners[change.point] = change.to.index();
    for (const SiteNumber s : owned.sites.all()) {
      if (s.index() % 10 == 0)
        owned.sites.at(s)[0] = owned.metric.into_box(owned.sites.at(s)[0] + 0.004, 0);
    }
  }
}

TEST_CASE_TEMPLATE("cells that follow their points are as those gathered", Scalar, float, double) {
  for (const int dimension : {1, 2, 5}) {
    for (const bool periodic : {false, true}) {
      CAPTURE(dimension);
      CAPTURE(periodic);
      const Box box = uneven_box(dimension);
      const auto points = make_points<Scalar>(Layout::random, box, 2000);
      Owned<Scalar> owned(points, box, 60, periodic);
      const Arena arena(1);
      const PointsView<Scalar> view = ccvt::view_points(points);
      OwnerBounds<Scalar> bounds(owned.metric, view, arena);
      MovingCells cells(owned.metric);
      int followed = 0;
      for (int iteration = 0; iteration < 25; ++iteration) {
        const auto all = bounds.changes(owned.sites, owned.owners, 0);
        for (const OwnerChange& change : all) {
          const Scalar* const x = points.col(change.point.index()).data();
          if (iteration > 0) {
            cells.leave(SiteNumber(owned.owners[change.point]), x);
            cells.join(owned.sites, change.to, x);
          }
          owned.owners[change.point] = change.to.index();
        }
        const auto sizes = ccvt::cell_sizes(owned.owners, owned.sites.count());
        Cells<Scalar> gathered(dimension, sizes);
        std::vector<Index> filled(sizes.size(), 0);
        for (const PointNumber p : points_below(owned.owners.size())) {
          const SiteNumber s(owned.owners[p]);
          gathered.put(s, filled[s]++, PointOfAll(p.index()), points.col(p.index()).data());
        }
        SiteState expected = owned.sites;
        for (const SiteNumber s : expected.all()) {
          if (iteration > 0) REQUIRE(cells.count(s) == sizes[s]);
          expected.radius[s] = std::numeric_limits<double>::infinity();
          if (sizes[s] > 0) update_site(owned.metric, gathered, expected, s);
        }
        for (const SiteNumber s : expected.all()) {
          if (iteration == 0 || cells.worn(owned.sites, s) || sizes[s] == 0) continue;
          ++followed;
          cells.update(owned.sites, s);
          CHECK(owned.metric.squared_distance(owned.sites.at(s), expected.at(s)) < 1e-24);
          CHECK(owned.sites.energy[s] == doctest::Approx(expected.energy[s]).epsilon(1e-12));
          CHECK(owned.sites.radius[s] >= expected.radius[s] * (1 - 1e-12));
        }
        if (iteration % 8 == 0) {
          for (const SiteNumber s : expected.all()) {
            if (sizes[s] == 0) expected.energy[s] = expected.radius[s] = 0;
          }
          owned.sites = expected;
          cells.take(owned.sites, sizes);
        }
        for (const SiteNumber s : expected.all()) {
          if (iteration % 8 != 0) owned.sites.radius[s] = expected.radius[s] * (1 + 1e-12);
        }
      }
      CHECK(followed > 50);
    }
  }
}

TEST_CASE("a cell wears out when it changes much, or is large on a torus") {
  const Box box = Box::unit(1);
  Points<double> points(1, 8);
  points << 0.40, 0.41, 0.42, 0.43, 0.44, 0.45, 0.46, 0.47;
  Owned<double> owned(points, box, 1, true);
  const SiteNumber site(0);
  owned.sites.at(site)[0] = 0.435;
  owned.bound_radii();
  MovingCells cells(owned.metric);
  cells.take(owned.sites, {8});
  CHECK_FALSE(cells.worn(owned.sites, site));
  for (Index k = 0; k < 4; ++k) cells.leave(site, points.col(k).data());
  CHECK_FALSE(cells.worn(owned.sites, site));
  cells.leave(site, points.col(4).data());
  CHECK(cells.worn(owned.sites, site));
  cells.take(owned.sites, {8});
  const double opposite = 0.935;
  cells.join(owned.sites, site, &opposite);
  CHECK(cells.worn(owned.sites, site));
}

TEST_CASE("a sum that takes away what it was given is as exact as one that never had it") {
  CompensatedSum sum;
  Random random(3);
  std::vector<double> large;
  for (int k = 0; k < 1000; ++k) large.push_back(1e9 * random.uniform());
  for (const double x : large) sum.add(x);
  sum.add(0x1p-30);
  for (const double x : large) sum.add(-x);
  CHECK(sum.value() == 0x1p-30);
}

TEST_SUITE_END();
