#include "exact/assignment.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <type_traits>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/sampling.h"
#include "cell_sizes.h"
#include "exact/cell_bounds.h"
#include "exact/move_costs.h"
#include "exact/pricing.h"
#include "geometry/squares.h"
#include "parallel/stop.h"
#include "random.h"
#include "support/flow.h"
#include "support/generate.h"
#include "support/oracle.h"

namespace ccvt::test {
namespace {

struct Solved {
  std::vector<Index> owners;
  std::vector<double> weights;
  Certificate certificate;
};

template <class Scalar>
Solved solve(const Domain& domain, const Points<Scalar>& points, const std::vector<double>& sites,
             const std::vector<Index>& capacities, int threads = 1) {
  const auto dimension = static_cast<int>(points.rows());
  const auto n = static_cast<Index>(sites.size() / static_cast<std::size_t>(dimension));
  const Metric metric(dimension, domain);
  const Arena arena(threads);
  ExactAssignment<Scalar> assignment(metric, view_points(points), n, capacities, arena);
  Solved solved;
  solved.weights.assign(static_cast<std::size_t>(n), 0.0);
  solved.owners.assign(static_cast<std::size_t>(points.cols()), 0);
  solved.certificate = assignment.solve(sites, solved.weights, solved.owners);
  return solved;
}

std::vector<Index> sizes(const std::vector<Index>& owners, std::size_t n) {
  std::vector<Index> result(n, 0);
  for (const Index owner : owners) ++result[static_cast<std::size_t>(owner)];
  return result;
}

/// By how much some point is cheaper at another site, over the largest squared distance; by brute
/// force over all points and sites.
template <class Scalar>
double violation(const Domain& domain, const Points<Scalar>& points,
                 const std::vector<double>& sites, const Solved& solved) {
  const auto dimension = static_cast<int>(points.rows());
  Real worst = 0;
  Real largest = std::numeric_limits<double>::min();
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const auto reduced = [&](std::size_t s) {
      const Real squared = squared_distance(domain, dimension, points.col(p).data(),
                                            sites.data() + s * static_cast<std::size_t>(dimension));
      largest = std::max(largest, squared);
      return squared - static_cast<Real>(solved.weights[s]);
    };
    const Real own = reduced(static_cast<std::size_t>(solved.owners[static_cast<std::size_t>(p)]));
    for (std::size_t s = 0; s < solved.weights.size(); ++s) {
      worst = std::max(worst, own - reduced(s));
    }
  }
  return static_cast<double>(worst / largest);
}

template <class Scalar>
double cost_of(const Domain& domain, const Points<Scalar>& points, const std::vector<double>& sites,
               const std::vector<Index>& owners) {
  const auto dimension = static_cast<int>(points.rows());
  Real sum = 0;
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    const auto owner = static_cast<std::size_t>(owners[static_cast<std::size_t>(p)]);
    sum += squared_distance(domain, dimension, points.col(p).data(),
                            sites.data() + owner * static_cast<std::size_t>(dimension));
  }
  return static_cast<double>(sum);
}

template <class Scalar>
std::vector<double> some_sites(const Points<Scalar>& points, Index count, std::uint64_t seed) {
  Random random(seed, 99);
  std::vector<double> sites;
  for (Index s = 0; s < count; ++s) {
    const auto p =
        static_cast<Eigen::Index>(random.below(static_cast<std::uint64_t>(points.cols())));
    for (Eigen::Index d = 0; d < points.rows(); ++d) {
      sites.push_back(static_cast<double>(points(d, p)));
    }
  }
  return sites;
}

/// As uneven as can be, summing to `total`.
std::vector<Index> uneven(Index total, Index sites) {
  std::vector<Index> capacities = equal_capacities(total, sites);
  Random random(5, 98);
  for (Index k = 0; k < sites; ++k) {
    auto& from = capacities[static_cast<std::size_t>(k)];
    const auto to = random.below(static_cast<std::uint64_t>(sites));
    const auto amount = static_cast<Index>(random.below(static_cast<std::uint64_t>(from)));
    from -= amount;
    capacities[to] += amount;
  }
  return capacities;
}

}  // namespace

TEST_SUITE_BEGIN("assignment");

TEST_CASE("costs what the flow solver finds, and carries a certificate") {
  for (const int dimension : {2, 16, 128}) {
    for (const Layout layout : all_layouts) {
      const Index m = dimension <= 16 ? 4096 : 600;
      const Index n = dimension <= 16 && layout != Layout::one_place ? 64 : 24;
      CAPTURE(dimension);
      CAPTURE(name_of(layout));
      const auto points = make_points<float>(layout, uneven_box(dimension), m);
      const auto sites = some_sites(points, n, 3);
      const auto capacities = uneven(m, n);
      const Solved solved = solve(Domain(), points, sites, capacities);
      CHECK(sizes(solved.owners, static_cast<std::size_t>(n)) == capacities);
      CHECK(violation(Domain(), points, sites, solved) < 1e-12);
      const double cost = cost_of(Domain(), points, sites, solved.owners);
      CHECK(solved.certificate.energy == doctest::Approx(cost).epsilon(1e-12));
      CHECK(solved.certificate.gap <= 1e-12 * cost);
#ifdef CCVT_TEST_FLOW
      const double least = least_cost(points, sites, capacities);
      const double extent = uneven_box(dimension).extent().squaredNorm();
      CHECK(std::abs(cost - least) <= 1e-11 * least + 1e-13 * m * extent);
#endif
    }
  }
}

TEST_CASE("the cheapest of all assignments, by enumeration") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto points =
        make_points<double>(seed % 2 == 0 ? Layout::grid : Layout::random, uneven_box(2), 8, seed);
    const auto sites = some_sites(points, 3, seed);
    const std::vector<Index> capacities{1, 5, 2};
    std::vector<Index> owners{0, 1, 1, 1, 1, 1, 2, 2};
    double least = std::numeric_limits<double>::infinity();
    double floating = least;
    do {
      least = std::min(least, cost_of(Domain(), points, sites, owners));
    } while (std::next_permutation(owners.begin(), owners.end()));
    // Which cell has two points, and which have three, is open.
    for (const std::vector<Index>& start : {std::vector<Index>{0, 0, 1, 1, 1, 2, 2, 2},
                                            {0, 0, 0, 1, 1, 2, 2, 2},
                                            {0, 0, 0, 1, 1, 1, 2, 2}}) {
      owners = start;
      do {
        floating = std::min(floating, cost_of(Domain(), points, sites, owners));
      } while (std::next_permutation(owners.begin(), owners.end()));
    }
    const Solved fixed = solve(Domain(), points, sites, capacities);
    CHECK(cost_of(Domain(), points, sites, fixed.owners) == doctest::Approx(least).epsilon(1e-12));
    const Solved open = solve(Domain(), points, sites, {});
    CHECK(cost_of(Domain(), points, sites, open.owners) ==
          doctest::Approx(floating).epsilon(1e-12));
  }
}

TEST_CASE("optimal on a torus too") {
  const Box box = uneven_box(2);
  const Domain torus = Domain::periodic(box);
  for (const Layout layout : all_layouts) {
    CAPTURE(name_of(layout));
    const auto points = make_points<double>(layout, box, 1000);
    const auto sites = some_sites(points, 20, 4);
    const Solved solved = solve(torus, points, sites, uneven(1000, 20));
    CHECK(sizes(solved.owners, 20) == uneven(1000, 20));
    CHECK(violation(torus, points, sites, solved) < 1e-12);
  }
}

TEST_CASE("far clouds whose sizes do not fit the capacities") {
  const auto points = make_points<float>(Layout::clusters, uneven_box(3), 3000);
  for (const Index n : {2, 3, 7, 60}) {
    const auto sites = some_sites(points, n, 8);
    const Solved solved = solve(Domain(), points, sites, equal_capacities(3000, n));
    CHECK(sizes(solved.owners, static_cast<std::size_t>(n)) == equal_capacities(3000, n));
    CHECK(violation(Domain(), points, sites, solved) < 1e-12);
  }
}

TEST_CASE("the cheapest, too, where points are far from the origin") {
  // On a grid, so that moving them by 2^26 is exact.
  const auto on_grid = [](const Points<double>& x) -> Points<double> {
    return (x.array() * 0x1p16).round() / 0x1p26;
  };
  for (const int dimension : {1, 2}) {
    CAPTURE(dimension);
    const auto drawn = [&](Index count, std::uint64_t seed) {
      return sample_uniform(Box::unit(dimension), count, seed, Distribution::white);
    };
    const Points<double> points = on_grid(drawn(3000, 1));
    const Points<double> sites = on_grid(drawn(100, 2));
    const Points<double> nudged = sites + on_grid(0.001 * drawn(100, 3));
    const auto solve_at = [&](double origin) {
      const Metric metric(dimension, Domain());
      const Arena arena(1);
      const Points<double> moved = points.array() + origin;
      ExactAssignment<double> assignment(metric, view_points(moved), 100,
                                         equal_capacities(3000, 100), arena);
      std::vector<double> weights(100, 0.0);
      std::vector<Index> owners(3000, 0);
      Certificate certificate;
      // The second time owners and weights are nearly right.
      for (const Points<double>& some : {sites, nudged}) {
        const Points<double> there = some.array() + origin;
        certificate =
            assignment.solve({there.data(), there.data() + there.size()}, weights, owners);
      }
      return certificate;
    };
    const Certificate near = solve_at(0);
    const Certificate far = solve_at(0x1p26);
    CHECK(far.energy == doctest::Approx(near.energy).epsilon(1e-12));
    CHECK(far.gap <= 1e-12 * far.energy);
  }
}

TEST_CASE("one round is enough, also where sites start without points or with all of them") {
  for (const int dimension : {2, 9}) {
    CAPTURE(dimension);
    const auto points = make_points<float>(Layout::random, uneven_box(dimension), 1200);
    auto sites = some_sites(points, 60, 4);
    // Two of three sites far from all points, one after the other.
    const double extent = uneven_box(dimension).extent().maxCoeff();
    const auto width = static_cast<std::size_t>(dimension);
    for (std::size_t k = 0; k < sites.size(); ++k) {
      if (k / width % 3 != 0) sites[k] += extent * static_cast<double>(1 + k / width);
    }
    const Solved solved = solve(Domain(), points, sites, equal_capacities(1200, 60));
    CHECK(solved.certificate.rounds == 2);  // the second one proves the first
    CHECK(violation(Domain(), points, sites, solved) < 1e-12);
  }
}

TEST_CASE("more sites than have their edges at hand") {
  const Index n = 1200;  // of 1199 edges 218 are, at first
  const auto points = make_points<float>(Layout::clusters, uneven_box(4), 2400);
  const auto sites = some_sites(points, n, 6);
  std::vector<Index> capacities = uneven(2400, n);
  // Two of three want no point.
  for (std::size_t s = 0; s + 2 < capacities.size(); s += 3) {
    capacities[s] += capacities[s + 1] + capacities[s + 2];
    capacities[s + 1] = capacities[s + 2] = 0;
  }
  // On a torus no bounds are kept: those of edges that are not at hand follow from other cells.
  for (const Domain& domain : {Domain(), Domain::periodic(uneven_box(4))}) {
    const Solved solved = solve(domain, points, sites, capacities);
    CHECK(sizes(solved.owners, static_cast<std::size_t>(n)) == capacities);
    CHECK(solved.certificate.rounds == 2);
    CHECK(violation(domain, points, sites, solved) < 1e-12);
  }
}

TEST_CASE_TEMPLATE("bounds of what moving costs hold, and are close", Scalar, float, double) {
  for (const int dimension : {1, 2, 7, 64}) {
    for (const bool periodic : {false, true}) {
      CAPTURE(dimension);
      CAPTURE(periodic);
      const Box box = uneven_box(dimension);
      const auto points = make_points<Scalar>(Layout::random, box, 400);
      const auto sites = some_sites(points, 50, 2);
      const Metric metric(dimension, periodic ? Domain::periodic(box) : Domain());
      const SquaredDistances<Scalar> costs(metric, view_points(points), sites);
      const std::vector<Index> owners = Pricer<Scalar>(metric, view_points(points), Arena(1))
                                            .cheapest({sites, std::vector<double>(50, 0.0)});
      const Grouping cells(owners, 50);
      MoveCosts::Scratch scratch;
      double slack = 0;
      double largest = 0;
      for (const SiteNumber i : sites_below(50)) {
        if (cells.of(i).empty()) continue;
        const std::span<const double> found = costs.bounds(i, cells.of(i), scratch);
        const std::vector<double> bounds(found.begin(), found.end());
        for (const SiteNumber j : sites_below(50)) {
          double least = std::numeric_limits<double>::infinity();
          std::vector<double> here;
          std::vector<double> there;
          costs.squared(cells.of(i), i, here);
          costs.squared(cells.of(i), j, there);
          for (std::size_t k = 0; k < here.size(); ++k) {
            least = std::min(least, there[k] - here[k]);
            std::vector<double> some;
            costs.squared_to(cells.of(i)[k], std::vector<SiteNumber>{i, j}, some, scratch);
            CHECK(some == std::vector<double>{here[k], there[k]});
          }
          CHECK(bounds[j] <= least);
          slack = std::max(slack, least - bounds[j]);
          largest = std::max(largest, std::abs(least));
        }
      }
      if (!periodic) CHECK(slack < 1e-3 * largest);
    }
  }
}

TEST_CASE_TEMPLATE("squared distances in float are below those in double, and close", Scalar, float,
                   double) {
  struct Place {
    double scale;
    double offset;
    double slack;  ///< as a share of the largest square
  };
  for (const int dimension : {3, 16, 21, 64}) {
    // From places where float is too coarse, or squares too large or small for it, too.
    for (const Place place : {Place{1, 0, 1e-4}, Place{1e-3, 100, 10}, Place{1e19, 0, 1e-12},
                              Place{1e-21, 0, 1e6}, Place{1e-30, 0, 1e24}}) {
      CAPTURE(dimension);
      CAPTURE(place.scale);
      const Box box = uneven_box(dimension);
      Points<Scalar> points = make_points<Scalar>(Layout::random, box, 300);
      points.array() =
          points.array() * static_cast<Scalar>(place.scale) + static_cast<Scalar>(place.offset);
      const auto sites = some_sites(points, 70, 2);
      const Metric metric(dimension, Domain());
      const SquaredDistances<Scalar> costs(metric, view_points(points), sites);
      std::vector<PointNumber> all;
      for (const PointNumber p : points_below(300)) all.push_back(p);
      MoveCosts::Scratch scratch;
      std::vector<double> exact;
      std::vector<double> least;
      std::vector<double> slack;
      std::vector<SiteNumber> to;
      for (const SiteNumber s : sites_below(70)) to.push_back(s);
      costs.squared_at_least(all, to, least, slack);
      REQUIRE(least.size() == 70 * all.size());
      for (const SiteNumber s : to) {
        costs.squared(all, s, exact);
        const double largest = *std::max_element(exact.begin(), exact.end());
        CHECK(slack[s] <= place.slack * largest);
        bool between = true;
        for (std::size_t k = 0; k < all.size(); ++k) {
          const double lower = least[s * all.size() + k];
          between = between && lower <= exact[k] && exact[k] <= lower + slack[s];
        }
        CHECK(between);
      }
      for (const PointNumber p : all) {
        costs.squared_to(p, to, exact, scratch);
        const double largest = *std::max_element(exact.begin(), exact.end());
        const std::span<const double> found = costs.squared_at_least_to_all(p, scratch);
        REQUIRE(found.size() == exact.size());
        bool between = true;
        for (std::size_t k = 0; k < found.size(); ++k) {
          between = between && found[k] <= exact[k] &&
                    exact[k] <= found[k] + 1e-13 * exact[k] + place.slack * largest;
        }
        CHECK(between);
      }
    }
  }
}

TEST_CASE_TEMPLATE("bounds that are kept hold while sites move and points come and go", Scalar,
                   float, double) {
  for (const int dimension : {1, 2, 7, 64}) {
    for (const double length : {1e-6, 1e-2, 1.0}) {
      CAPTURE(dimension);
      CAPTURE(length);
      constexpr std::size_t kSites = 40;
      const Arena arena(2);
      const auto points = make_points<Scalar>(Layout::random, uneven_box(dimension), 5000);
      const Metric metric(dimension, Domain());
      const Pricer<Scalar> pricer(metric, view_points(points), arena);
      std::vector<double> sites = some_sites(points, kSites, 2);
      std::vector<double> weights(kSites, 0.0);
      // One cell has several parts, and one no points.
      std::vector<Index> owners(5000, 0);
      for (std::size_t p = 2500; p < 5000; ++p) owners[p] = static_cast<Index>(p % (kSites - 1));
      CellBounds kept(owners.size(), kSites);
      Random random(5, 1);
      std::size_t looked_at = 0;
      for (int round = 0; round < 6; ++round) {
        std::vector<Index> expected = owners;
        const Prices all = pricer.price({sites, weights}, expected);
        const std::vector<Index> given = owners;
        const Prices some = pricer.price({sites, weights}, owners, &kept);
        CHECK(owners == expected);
        CHECK(some.moved == all.moved);
        CHECK(some.energy == doctest::Approx(all.energy).epsilon(1e-12));
        CHECK(std::abs(some.cheapest_energy - all.cheapest_energy) <= 1e-12 * all.energy);
        CHECK(some.gap == doctest::Approx(all.gap).epsilon(1e-9));
        CHECK(kept.cover(given));
        const SquaredDistances<Scalar> costs(metric, view_points(points), sites);
        if (round % 3 == 1) {
          kept.set_all(owners, costs, arena);
          CHECK_FALSE(kept.cover(owners));
        }
        kept.include_all(owners, costs, arena);
        CHECK(kept.cover(owners));
        const Grouping cells(owners, kSites);
        for (const SiteNumber i : sites_below(kSites)) {
          bool holds = true;
          std::vector<double> least(kSites, std::numeric_limits<double>::infinity());
          double largest = 0;
          for (const PointNumber p : cells.of(i)) {
            const Scalar* x = points.col(p.index()).data();
            const auto squared_to = [&](SiteNumber s) {
              return squared_difference(x, sites.data() + s * sites.size() / kSites, dimension);
            };
            const double own = squared_to(i);
            holds = holds && kept.own_costs()[p] == own;
            holds = holds && std::sqrt(own) <= kept.radius(i);
            for (const SiteNumber j : sites_below(kSites)) {
              const double there = squared_to(j);
              const bool below = kept.of(i)[j] <= there - own + 1e-14 * (there + own);
              holds = holds && (j == i || below);
              least[j] = std::min(least[j], there - own);
              largest = std::max(largest, there + own);
            }
          }
          CHECK(holds);
          for (const SiteNumber j : sites_below(kSites)) {
            const bool empty = cells.of(i).empty();
            const bool close = empty || j == i || kept.of(i)[j] > least[j] - 1e-3 * largest;
            CHECK((round % 3 != 1 || close));
          }
          std::vector<SiteNumber> near;
          kept.select(i, weights, near);
          CHECK(kept.any_near(i, weights) == !near.empty());
          looked_at += near.size();
        }
        // Some sites move, some weights change, and some points are moved to cells of others.
        for (std::size_t k = 0; k < sites.size(); ++k) {
          if (round % 2 == 0 || k < sites.size() / 3) sites[k] += length * (random.uniform() - .5);
        }
        for (double& weight : weights) weight += length * random.uniform();
        if (round == 3) {
          const PointNumber p(17);
          MoveCosts::Scratch scratch;
          const SiteNumber to((owners[p] + 1) % static_cast<Index>(kSites));
          kept.remove(p);
          CHECK_FALSE(kept.cover(owners));
          std::vector<double> own;
          costs.squared({&p, 1}, to, own);
          kept.include(to, p, costs.squared_at_least_to_all(p, scratch), own.front());
          owners[p] = to.index();
          CHECK(kept.cover(owners));
        }
      }
      if (length == 1e-6 && dimension < 64) CHECK(looked_at < 6 * kSites * (kSites - 1) / 2);
      CHECK(looked_at < 6 * kSites * (kSites - 1));
    }
  }
}

TEST_CASE_TEMPLATE("an assignment that is kept is as good as a new one when sites move", Scalar,
                   float, double) {
  for (const int dimension : {2, 3, 20}) {
    for (const double scale : {1.0, 1e100, 1e-100}) {
      if (std::is_same_v<Scalar, float> && scale != 1) continue;
      CAPTURE(dimension);
      CAPTURE(scale);
      constexpr Index kSites = 25;
      const Arena arena(2);
      Points<Scalar> points = make_points<Scalar>(Layout::clusters, uneven_box(dimension), 1200) *
                              static_cast<Scalar>(scale);
      const Metric metric(dimension, Domain());
      std::vector<double> sites = some_sites(points, kSites, 4);
      const std::vector<Index> capacities = uneven(1200, kSites);
      ExactAssignment<Scalar> kept(metric, view_points(points), kSites, capacities, arena);
      std::vector<double> weights(kSites, 0.0);
      std::vector<Index> owners(1200, 0);
      Random random(2, 9);
      for (int round = 0; round < 8; ++round) {
        kept.improve(sites, weights, owners);
        std::vector<double> other_weights(kSites, 0.0);
        std::vector<Index> other(1200, 0);
        ExactAssignment<Scalar> fresh(metric, view_points(points), kSites, capacities, arena);
        const Certificate best = fresh.solve(sites, other_weights, other);
        CHECK(cell_sizes(owners, kSites) == capacities);
        double energy = 0;
        for (Index p = 0; p < 1200; ++p) {
          const auto s = static_cast<std::size_t>(owners[static_cast<std::size_t>(p)]);
          energy +=
              squared_difference(points.col(p).data(),
                                 sites.data() + s * static_cast<std::size_t>(dimension), dimension);
        }
        CHECK(energy == doctest::Approx(best.energy).epsilon(1e-12));
        const double length = scale * (round < 4 ? .03 : 1e-5);
        for (double& x : sites) x += length * (random.uniform() - .5);
      }
    }
  }
}

TEST_CASE("bounds are not trusted after a stop in the middle") {
  constexpr std::size_t kSites = 500;
  const auto points = make_points<float>(Layout::random, uneven_box(8), 4000);
  const Metric metric(8, Domain());
  bool stopping = false;
  Stop stop([&] { return stopping; });
  const Arena arena(1, &stop);
  const Pricer<float> pricer(metric, view_points(points), arena);
  std::vector<double> sites = some_sites(points, kSites, 2);
  const std::vector<double> weights(kSites, 0.0);
  const std::vector<Index> given(4000, 0);
  CellBounds kept(given.size(), kSites);
  std::vector<Index> owners = given;
  pricer.price({sites, weights}, owners, &kept);
  CHECK(kept.cover(given));
  for (double& x : sites) x += .01;
  stopping = true;
  CHECK(stop.requested());
  owners = given;
  CHECK_THROWS_AS(pricer.price({sites, weights}, owners, &kept), Stopped);
  // It may have come before they changed; where they follow sites it comes in between.
  const Grouping groups(given, kSites);
  CHECK_THROWS_AS(kept.follow(sites, groups, view_points(points), arena), Stopped);
  CHECK_FALSE(kept.cover(given));
}

TEST_CASE("the number of threads changes no bit") {
  const auto points = make_points<float>(Layout::clusters, uneven_box(5), 3000);
  const auto sites = some_sites(points, 40, 8);
  const Solved one = solve(Domain(), points, sites, uneven(3000, 40), 1);
  const Solved four = solve(Domain(), points, sites, uneven(3000, 40), 4);
  CHECK(one.owners == four.owners);
  CHECK(one.weights == four.weights);
}

TEST_SUITE_END();

}  // namespace ccvt::test
