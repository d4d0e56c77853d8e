// First owners: capacities exact, and each way's own promise.
#include "relax/initialize.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Filling;
using ccvt::Index;
using ccvt::Initialization;
using ccvt::JoiningPoints;
using ccvt::Metric;
using ccvt::PointNumber;
using ccvt::PointOfAll;
using ccvt::Points;
using ccvt::SiteNumber;
using ccvt::SiteState;
using namespace ccvt::test;

namespace {

constexpr Initialization starts[] = {Initialization::balanced, Initialization::coherent,
                                     Initialization::random};

template <class Scalar>
class Start {
 public:
  Start(Layout layout, int dimension, bool periodic, const std::vector<Index>& sizes)
      : box(uneven_box(dimension)),
        domain(periodic ? Domain::periodic(box) : Domain()),
        metric(dimension, domain),
        capacities(sizes),
        points(make_points<Scalar>(layout, box, sum_of(sizes))),
        sites(dimension, sizes.size()) {
    const auto places = make_points<Scalar>(layout, box, site_count(), 5);
    for (const SiteNumber s : sites.all()) {
      for (int d = 0; d < dimension; ++d) {
        sites.at(s)[d] = metric.into_box(static_cast<double>(places(d, s.index())), d);
      }
    }
  }

  [[nodiscard]] Index site_count() const { return static_cast<Index>(sites.count()); }

  /// The owners after the first `early` points have been dealt out in turn and the others joined.
  std::vector<Index> owners(Initialization way, Index early = 0, std::uint64_t seed = 1) {
    Cells<Scalar> cells(metric.dimension(), capacities);
    const auto view = ccvt::view_points(points);
    Filling<Scalar> filling(cells, view);
    SiteNumber site;
    for (Index p = 0; p < early; ++p) {
      while (filling.surplus(site) >= 0) site = SiteNumber((site + 1) % sites.count());
      filling.add(site, PointNumber(p));
      site = SiteNumber((site + 1) % sites.count());
    }
    const auto joining = JoiningPoints::between(PointNumber(early), PointNumber(points.cols()));
    switch (way) {
      case Initialization::balanced:
        ccvt::join_balanced(metric, sites, box, joining, {}, Arena(1), filling);
        break;
      case Initialization::coherent:
        ccvt::join_coherent(metric, sites, joining.all(), seed, filling);
        break;
      case Initialization::random:
        ccvt::join_random(joining.all(), seed, filling);
        break;
      case Initialization::automatic:
        FAIL("the solver chooses; nothing here joins automatically");
    }
    std::vector<Index> result(static_cast<std::size_t>(points.cols()), -1);
    for (const SiteNumber s : sites.all()) {
      CHECK(filling.surplus(s) == 0);
      CHECK(filling.waiting(s) == 0);
      Index k = 0;
      for (const PointOfAll p : cells.points(s)) {
        CHECK(result[p] == -1);
        result[p] = s.index();
        std::vector<Scalar> x(sites.dimension);
        cells.get(s, k++, x.data());
        CHECK(std::equal(x.begin(), x.end(), points.col(p.index()).data()));
      }
    }
    return result;
  }

  [[nodiscard]] Real squared(Index point, Index site) const {
    return squared_distance(domain, metric.dimension(), points.col(point).data(),
                            sites.at(SiteNumber(site)));
  }
  [[nodiscard]] Real energy(const std::vector<Index>& owner) const {
    Real sum = 0;
    for (Index p = 0; p < points.cols(); ++p) sum += squared(p, owner[static_cast<std::size_t>(p)]);
    return sum;
  }

  Box box;
  Domain domain;
  Metric metric;
  std::vector<Index> capacities;
  Points<Scalar> points;
  SiteState sites;
};

// Program 6, certified without its order: a point may pass over a nearer site only if that site
// was full already. So "site t was full before site s was" for each point of s that is nearer to t,
// and these statements must not go in a circle.
template <class Scalar>
bool some_order_explains(const Start<Scalar>& start, const std::vector<Index>& owner) {
  const std::size_t n = start.sites.count();
  std::vector<std::vector<bool>> before(n, std::vector<bool>(n, false));
  for (Index p = 0; p < start.points.cols(); ++p) {
    const Index own = owner[static_cast<std::size_t>(p)];
    const Real distance = start.squared(p, own);
    for (Index t = 0; t < start.site_count(); ++t) {
      if (start.squared(p, t) < distance * (1 - 1e-9L)) {
        before[static_cast<std::size_t>(t)][static_cast<std::size_t>(own)] = true;
      }
    }
  }
  std::vector<bool> done(n, false);
  for (std::size_t round = 0; round < n; ++round) {
    std::size_t next = n;
    for (std::size_t s = 0; s < n && next == n; ++s) {
      bool ready = !done[s];
      for (std::size_t t = 0; t < n && ready; ++t) ready = done[t] || !before[t][s];
      if (ready) next = s;
    }
    if (next == n) return false;
    done[next] = true;
  }
  return true;
}

}  // namespace

TEST_SUITE_BEGIN("initialize");

TEST_CASE_TEMPLATE("every way fills the cells exactly", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 9}) {
    for (const bool periodic : {false, true}) {
      if (periodic && dimension > 5) continue;
      for (const Layout layout : all_layouts) {
        for (const auto& capacities :
             {std::vector<Index>(40, 7), unequal_capacities(12), std::vector<Index>(60, 1),
              std::vector<Index>{500}, std::vector<Index>{1, 99}}) {
          for (const Initialization way : starts) {
            CAPTURE(dimension);
            CAPTURE(periodic);
            CAPTURE(name_of(layout));
            CAPTURE(static_cast<int>(way));
            Start<Scalar> start(layout, dimension, periodic, capacities);
            start.owners(way);  // checks inside
            start.owners(way, sum_of(capacities) / 3);
            CHECK(start.owners(way) == start.owners(way));
          }
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("coherent: no point passes over a nearer site with room", Scalar, float,
                   double) {
  for (const int dimension : {1, 2, 3, 9}) {
    for (const bool periodic : {false, true}) {
      if (periodic && dimension > 5) continue;
      for (const Layout layout : {Layout::random, Layout::clusters, Layout::grid}) {
        CAPTURE(dimension);
        CAPTURE(periodic);
        CAPTURE(name_of(layout));
        Start<Scalar> start(layout, dimension, periodic, std::vector<Index>(30, 10));
        CHECK(some_order_explains(start, start.owners(Initialization::coherent)));
        if (layout == Layout::random) {
          CHECK_FALSE(some_order_explains(start, start.owners(Initialization::random)));
        }
        CHECK(start.owners(Initialization::coherent, 0, 1) !=
              start.owners(Initialization::coherent, 0, 2));
      }
    }
  }
}

TEST_CASE("coherent: the look-ahead changes nothing, with any number of threads") {
  for (const auto& capacities : {std::vector<Index>(200, 10), std::vector<Index>(3, 400),
                                 std::vector<Index>(500, 1), unequal_capacities(40)}) {
    for (const int dimension : {2, 9}) {
      Start<double> start(Layout::random, dimension, false, capacities);
      const auto owners = start.owners(Initialization::coherent);
      CHECK(some_order_explains(start, owners));
      const auto view = ccvt::view_points(start.points);
      std::vector<PointNumber> joining(static_cast<std::size_t>(start.points.cols()));
      std::iota(joining.begin(), joining.end(), PointNumber(0));
      for (const int threads : {2, 3, 8}) {
        Cells<double> cells(dimension, capacities);
        Filling<double> filling(cells, view);
        ccvt::join_coherent(start.metric, start.sites, joining, 1, filling, Arena(threads));
        for (const SiteNumber s : cells.sites()) {
          for (const PointOfAll p : cells.points(s)) REQUIRE(owners[p] == s.index());
        }
      }
    }
  }
}

TEST_CASE_TEMPLATE("where capacities allow it, every point gets its nearest site", Scalar, float,
                   double) {
  for (const int dimension : {1, 2, 3, 9}) {
    for (const bool periodic : {false, true}) {
      if (periodic && dimension > 5) continue;
      CAPTURE(dimension);
      CAPTURE(periodic);
      Start<Scalar> start(Layout::random, dimension, periodic, std::vector<Index>(20, 40));
      std::vector<Index> nearest(800);
      std::vector<Index> sizes(20, 0);
      for (Index p = 0; p < 800; ++p) {
        Index best = 0;
        for (Index s = 1; s < 20; ++s) {
          if (start.squared(p, s) < start.squared(p, best)) best = s;
        }
        nearest[static_cast<std::size_t>(p)] = best;
        ++sizes[static_cast<std::size_t>(best)];
      }
      REQUIRE(*std::min_element(sizes.begin(), sizes.end()) > 0);
      start.capacities = sizes;
      CHECK(start.owners(Initialization::balanced) == nearest);
      CHECK(start.owners(Initialization::coherent) == nearest);
    }
  }
}

TEST_CASE("between two sites the points change that lose least by it") {
  for (const Layout layout : {Layout::random, Layout::grid, Layout::duplicates}) {
    // So many change in one go, fewer and more than are told apart by columns.
    for (const Index moves : {-40, -17, -16, -15, -1, 1, 2, 15, 16, 17, 40}) {
      CAPTURE(name_of(layout));
      CAPTURE(moves);
      Start<double> start(layout, 2, false, {150, 150});
      Index size = 0;
      for (Index p = 0; p < 300; ++p) size += start.squared(p, 0) < start.squared(p, 1) ? 1 : 0;
      size = std::clamp(size - moves, 1, 299);
      start.capacities = {size, 300 - size};
      std::vector<Real> loss;
      Real least = 0;
      for (Index p = 0; p < 300; ++p) {
        loss.push_back(start.squared(p, 0) - start.squared(p, 1));
        least += start.squared(p, 1);
      }
      std::sort(loss.begin(), loss.end());
      for (Index k = 0; k < size; ++k) least += loss[static_cast<std::size_t>(k)];
      CHECK(start.energy(start.owners(Initialization::balanced)) ==
            doctest::Approx(static_cast<double>(least)).epsilon(1e-12));
    }
  }
}

TEST_CASE("balanced starts lower than coherent, and that lower than random") {
  for (const bool periodic : {false, true}) {
    Start<float> start(Layout::random, 2, periodic, std::vector<Index>(300, 30));
    const Real balanced = start.energy(start.owners(Initialization::balanced));
    const Real coherent = start.energy(start.owners(Initialization::coherent));
    const Real random = start.energy(start.owners(Initialization::random));
    CHECK(balanced < coherent);
    CHECK(coherent < random / 4);
  }
}

TEST_SUITE_END();
