#include "ccvt/metrics.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/solver.h"
#include "support/generate.h"
#include "support/lattices.h"
#include "support/message.h"

namespace ccvt::test {
namespace {

double distance(const PointSet& set, Eigen::Index a, Eigen::Index b) {
  Eigen::ArrayXd d = set.points().col(a) - set.points().col(b);
  const Eigen::ArrayXd extent = set.domain().box().extent();
  if (set.domain().is_periodic()) d -= extent * (d / extent).round();
  return std::sqrt(d.square().sum());
}

PointSet boxed(const PointSet& set) {
  return PointSet(set.points(), Domain::euclidean(set.domain().box()));
}

/// Voronoi neighbours by definition: on the bisector of two points, how long is the part that no
/// third one is nearer to? On a torus, 3 by 3 images of every point, or 5 by 5 of few.
BondOrder direct_bond_order(const PointSet& set) {
  using Eigen::Vector2d;
  const Box& box = set.domain().box();
  const Vector2d extent = box.extent();
  const int images = !set.domain().is_periodic() ? 0 : set.count() < 10 ? 2 : 1;
  BondOrder order;
  std::complex<double> global = 0;
  double cells = 0;
  for (Eigen::Index i = 0; i < set.points().cols(); ++i) {
    const Vector2d at = set.points().col(i);
    std::vector<Vector2d> others;
    for (Eigen::Index j = 0; j < set.points().cols(); ++j) {
      for (int x = -images; x <= images; ++x) {
        for (int y = -images; y <= images; ++y) {
          const Vector2d d = set.points().col(j) - at + Vector2d(x * extent[0], y * extent[1]);
          if (d.norm() > 0 && std::find(others.begin(), others.end(), d) == others.end()) {
            others.push_back(d);
          }
        }
      }
    }
    std::size_t walls = others.size();
    if (!set.domain().is_periodic()) {  // mirror images make the border
      for (int d = 0; d < 2; ++d) {
        for (const double wall : {box.lower[d], box.upper[d]}) {
          Vector2d mirrored = Vector2d::Zero();
          mirrored[d] = 2 * (wall - at[d]);
          others.push_back(mirrored);
        }
      }
    }
    std::complex<double> psi = 0;
    int neighbours = 0;
    bool inner = true;
    for (std::size_t j = 0; j < others.size(); ++j) {
      const Vector2d along(-others[j][1], others[j][0]);
      double from = -1e9;
      double to = 1e9;
      for (std::size_t k = 0; k < others.size(); ++k) {
        if (k == j) continue;
        // Points others[j] / 2 + t along with 2 x . others[k] <= |others[k]|^2.
        const double slope = 2 * along.dot(others[k]);
        const double room = others[k].squaredNorm() - others[j].dot(others[k]);
        if (slope > 0) to = std::min(to, room / slope);
        if (slope < 0) from = std::max(from, room / slope);
        if (slope == 0 && room < 0) to = from;
      }
      if ((to - from) * along.norm() <= 1e-4 * set.mean_spacing()) continue;
      if (j >= walls) inner = false;
      psi += std::polar(1.0, 6 * std::atan2(others[j][1], others[j][0]));
      ++neighbours;
    }
    if (!inner) continue;
    psi /= neighbours;
    global += psi;
    order.psi6_local += std::abs(psi);
    order.six_sided += neighbours == 6 ? 1 : 0;
    ++cells;
  }
  return {order.psi6_local / cells, std::abs(global) / cells, order.six_sided / cells};
}

void check_equal(const BondOrder& a, const BondOrder& b) {
  CHECK(a.psi6_local == doctest::Approx(b.psi6_local).epsilon(1e-9));
  CHECK(a.psi6_global == doctest::Approx(b.psi6_global).epsilon(1e-9));
  CHECK(a.six_sided == doctest::Approx(b.six_sided).epsilon(1e-9));
}

}  // namespace

TEST_SUITE_BEGIN("metrics");

TEST_CASE("energy, normalized energy and imbalance agree with the solver's summary") {
  const Box box = uneven_box(3);
  for (const Domain& domain : {Domain::periodic(box), Domain::euclidean(box)}) {
    const Points<double> points = make_points<double>(Layout::random, box, 900);
    Problem<double> problem(points, 30);
    problem.set_domain(domain);
    problem.set_capacities([] {
      std::vector<Index> capacities(30, 30);
      capacities[0] = 15;
      capacities[1] = 45;
      return capacities;
    }());
    const auto result = tessellate(problem);
    const double e = energy(points, result.sites, result.owners, domain);
    CHECK(e == doctest::Approx(result.summary.energy).epsilon(1e-12));
    CHECK(normalized_energy(e, 900, 30, box) ==
          doctest::Approx(result.summary.normalized_energy).epsilon(1e-12));
    CHECK(imbalance_factor(result.owners, 30) ==
          doctest::Approx(30.0 * (28 * 900 + 225 + 2025) / (900.0 * 900)).epsilon(1e-12));
    auto owners = result.owners;
    owners[7] = 30;
    CHECK(message_of([&] {
            energy(points, result.sites, owners, domain);
          }).find("owners[7] is 30") != std::string::npos);
    owners.pop_back();
    CHECK_THROWS_AS(energy(points, result.sites, owners, domain), InvalidInput);
  }
}

TEST_CASE("on a torus, energy is that of the images in the box") {
  const Box box{{-1, 2}, {3, 2.5}};
  const Points<double> points = make_points<double>(Layout::random, box, 200);
  const Points<double> sites = points.leftCols(7);
  std::vector<Index> owners(200);
  for (std::size_t p = 0; p < owners.size(); ++p) owners[p] = static_cast<Index>(p % 7);
  Points<double> far = points;
  Points<double> far_sites = sites;
  for (int p = 0; p < 200; ++p) far.col(p) += Eigen::Vector2d(4.0 * (p % 5), .5 - p % 3);
  for (int s = 0; s < 7; ++s) far_sites.col(s) -= Eigen::Vector2d(8.0 * (s % 2), s % 4);
  const Domain torus = Domain::periodic(box);
  const double expected = energy(points, sites, owners, torus);
  CHECK(energy(far, sites, owners, torus) == doctest::Approx(expected));
  CHECK(energy(points, far_sites, owners, torus) == doctest::Approx(expected));
  CHECK(energy(far, far_sites, owners, torus) == doctest::Approx(expected));
}

TEST_CASE("the densest lattices have distance 1") {
  const std::vector<PointSet> lattices = {cubic(1, 9),        hexagonal(8, 5),
                                          checkerboard(3, 3), checkerboard(4, 2),
                                          checkerboard(5, 2), e8()};
  for (const PointSet& set : lattices) {
    CAPTURE(set.dimension());
    const NearestDistances distances = nearest_distances(set);
    CHECK(distances.smallest == doctest::Approx(1).epsilon(1e-12));
    CHECK(distances.mean == doctest::Approx(1).epsilon(1e-12));
  }
  // E7 and E6 are cuts through E8: their densities are known, their cells are no cubes.
  CHECK(packing_distance(7) == doctest::Approx(2 * std::pow(1.0 / 16, 1.0 / 7)));
  CHECK(packing_distance(6) == doctest::Approx(2 * std::pow(1 / (8 * std::sqrt(3.0)), 1.0 / 6)));
  CHECK(packing_distance(9) == std::sqrt(2.0));
  CHECK_THROWS_AS(packing_distance(0), InvalidInput);
  for (const int dimension : {2, 3, 4}) {
    CHECK(nearest_distances(cubic(dimension, 4)).mean ==
          doctest::Approx(1 / packing_distance(dimension)));
  }
}

TEST_CASE("nearest distances and pair correlation are those of all pairs") {
  for (const int dimension : {1, 2, 3, 4, 7}) {
    for (const PointSet& set : {white(dimension, 150, 4), boxed(white(dimension, 150, 4)),
                                darts(dimension, 60, 0.005, 9)}) {
      CAPTURE(dimension);
      const double unit = packing_distance(dimension) * set.mean_spacing();
      double smallest = std::numeric_limits<double>::infinity();
      double mean = 0;
      const PairCorrelation found = pair_correlation({&set, 1});
      std::vector<double> pairs(found.value.size(), 0.0);
      for (Eigen::Index p = 0; p < set.count(); ++p) {
        double nearest = std::numeric_limits<double>::infinity();
        for (Eigen::Index q = 0; q < set.count(); ++q) {
          if (q == p) continue;
          const double d = distance(set, p, q);
          nearest = std::min(nearest, d);
          double weight = 1;
          const Eigen::ArrayXd gap = (set.points().col(p) - set.points().col(q)).array().abs();
          if (!set.domain().is_periodic()) weight = 1 / (1 - gap).prod();  // the box is a unit one
          const auto bin = static_cast<std::size_t>(d / (found.bin_width * set.mean_spacing()));
          if (bin < pairs.size()) pairs[bin] += weight;
        }
        smallest = std::min(smallest, nearest);
        mean += nearest / set.count();
      }
      const NearestDistances distances = nearest_distances(set, 3);
      CHECK(distances.smallest == doctest::Approx(smallest / unit).epsilon(1e-12));
      CHECK(distances.mean == doctest::Approx(mean / unit).epsilon(1e-12));
      for (std::size_t k = 0; k < pairs.size(); ++k) {
        const double r = static_cast<double>(k) * found.bin_width;
        const auto ball = [&](double x) {
          return std::pow(std::acos(-1.0), dimension / 2.0) / std::tgamma(dimension / 2.0 + 1) *
                 std::pow(x, dimension);
        };
        const double expected =
            pairs[k] / (set.count() - 1.0) / (ball(r + found.bin_width) - ball(r));
        CHECK(found.value[k] == doctest::Approx(expected).epsilon(1e-9));
      }
    }
  }
}

TEST_CASE("pair correlation: the last bin may end at half the box") {
  for (const Index side : {2, 4, 6, 8}) {
    const PointSet set(make_points<double>(Layout::random, Box::unit(2), side * side),
                       Domain::periodic(Box::unit(2)));
    CHECK(pair_correlation({&set, 1}).value.size() == static_cast<std::size_t>(8 * side));
  }
}

TEST_CASE("pair correlation: white noise is 1, Poisson disks keep their distance") {
  std::vector<PointSet> sets;
  std::vector<PointSet> boxes;
  for (std::uint64_t s = 1; s <= 20; ++s) {
    sets.push_back(white(2, 400, s));
    boxes.push_back(boxed(sets.back()));
  }
  for (const auto& group : {sets, boxes}) {
    const PairCorrelation g = pair_correlation(group);
    for (std::size_t k = 8; k < g.value.size(); ++k) CHECK(std::abs(g.value[k] - 1) < 0.1);
  }
  for (const auto& [dimension, radius] : {std::pair{2, 0.037}, {3, 0.105}, {4, 0.17}}) {
    const PointSet set = darts(dimension, 400, radius, 6);
    const double r = radius / set.mean_spacing();
    CHECK(nearest_distances(set).smallest * packing_distance(dimension) >= r * (1 - 1e-12));
    const PairCorrelation g = pair_correlation({&set, 1});
    for (std::size_t k = 0; (static_cast<double>(k) + 1) * g.bin_width < r; ++k) {
      CHECK(g.value[k] == 0);
    }
  }
}

TEST_CASE("bond order: lattices, and all Voronoi neighbours by definition") {
  check_equal(bond_order(hexagonal(7, 4)), {1, 1, 1});
  check_equal(bond_order(cubic(2, 8)), {0, 0, 0});
  const PointSet single(hexagonal(1, 1).points(), hexagonal(1, 1).domain());  // its own neighbour
  check_equal(bond_order(single), {1, 1, 1});
  for (const Index count : {2, 3, 5, 17, 80}) {
    CAPTURE(count);
    const PointSet set = white(2, count, 3);
    check_equal(bond_order(set, 3), direct_bond_order(set));
  }
  const PointSet open = boxed(white(2, 80, 3));
  check_equal(bond_order(open), direct_bond_order(open));
  const PointSet few = boxed(white(2, 3, 3));
  CHECK(std::isnan(bond_order(few).psi6_local));
  // Elongated box, duplicates.
  Points<double> points = make_points<double>(Layout::duplicates, uneven_box(2), 70);
  const PointSet twins(points, Domain::periodic(uneven_box(2)));
  check_equal(bond_order(twins), direct_bond_order(twins));
  CHECK_THROWS_AS(bond_order(white(3, 9, 1)), InvalidInput);
}

TEST_CASE("bond order: cells that many points may reach, and many points at one place") {
  // Those at the rim of a disc reach to the box.
  std::vector<Eigen::Vector2d> inside{{0, 0}};  // the box's corner
  const PointSet all = white(2, 600, 4);
  for (Eigen::Index p = 0; p < all.points().cols(); ++p) {
    const Eigen::Vector2d at = all.points().col(p);
    if ((at - Eigen::Vector2d(.5, .5)).norm() < .35) inside.emplace_back(at);
  }
  Points<double> points(2, std::ssize(inside));
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    points.col(p) = inside[static_cast<std::size_t>(p)];
  }
  REQUIRE(points.cols() > 200);
  const PointSet disc(points, Domain::euclidean(Box::unit(2)));
  check_equal(bond_order(disc), direct_bond_order(disc));
  // On a torus those of a cluster reach round it.
  points.rightCols(points.cols() - 1) *= 0.3;
  const PointSet cluster(points, Domain::periodic(Box::unit(2)));
  check_equal(bond_order(cluster), direct_bond_order(cluster));
  points.rightCols(points.cols() - 1) /= 0.3;
  // A cell at the border does not count, however many share it: this took minutes.
  Points<double> crowded(2, points.cols() + 20'000);
  crowded << points, Points<double>::Zero(2, 20'000);
  check_equal(bond_order(PointSet(crowded, disc.domain())), bond_order(disc));
}

TEST_CASE("integration: white noise is 1, even points are better") {
  for (const int dimension : {2, 3}) {
    for (const bool periodic : {true, false}) {
      IntegrationVariance sum;
      for (std::uint64_t s = 1; s <= 60; ++s) {
        const PointSet set = white(dimension, 200, s);
        const auto v = integration_variance(periodic ? set : boxed(set), s);
        sum.gaussian += v.gaussian / 60;
        sum.disk += v.disk / 60;
        sum.step += v.step / 60;
      }
      CAPTURE(dimension);
      CAPTURE(periodic);
      CHECK(sum.gaussian == doctest::Approx(1).epsilon(0.2));
      CHECK(sum.disk == doctest::Approx(1).epsilon(0.2));
      CHECK(sum.step == doctest::Approx(1).epsilon(0.35));
    }
  }
  const Box box = Box::unit(2);
  const PointSet even(sample_uniform<double>(box, 400, 1), Domain::periodic(box));
  const auto v = integration_variance(even);
  CHECK(v.gaussian < 0.1);
  CHECK(v.disk < 0.3);
  CHECK(v.step < 0.3);
}

TEST_CASE("analysis: means over the sets, the same bits for any number of threads, any place") {
  const std::vector<PointSet> sets = {darts(2, 200, 0.04, 1), darts(2, 200, 0.04, 2)};
  const Analysis one = analyze(sets, {.threads = 1});
  const Analysis many = analyze(sets, {.threads = 4});
  const auto figures = [](const Analysis& a) {
    std::vector<double> values = {a.distances.smallest,   a.distances.mean,   a.order.psi6_local,
                                  a.order.psi6_global,    a.order.six_sided,  a.star_discrepancy,
                                  a.integration.gaussian, a.integration.disk, a.integration.step};
    values.insert(values.end(), a.pairs.value.begin(), a.pairs.value.end());
    return values;
  };
  CHECK(figures(one) == figures(many));
  CHECK(one.sets == 2);
  CHECK(one.distances.mean ==
        doctest::Approx((nearest_distances(sets[0]).mean + nearest_distances(sets[1]).mean) / 2));
  CHECK(one.order.psi6_local ==
        doctest::Approx((bond_order(sets[0]).psi6_local + bond_order(sets[1]).psi6_local) / 2));
  std::vector<PointSet> moved;
  for (const PointSet& set : sets) {
    const Box box{Eigen::Vector2d(-3, 5), Eigen::Vector2d(-1, 7)};
    Points<double> points = set.points().rowwise().reverse();
    points.array() += 0.37;
    points.array() -= points.array().floor();
    points = (2 * points).colwise() + box.lower.eigen();
    moved.emplace_back(points, Domain::periodic(box));
  }
  const Analysis same = analyze(moved);
  CHECK(same.distances.smallest == doctest::Approx(one.distances.smallest));
  CHECK(same.distances.mean == doctest::Approx(one.distances.mean));
  CHECK(same.order.psi6_local == doctest::Approx(one.order.psi6_local));
  CHECK(same.order.psi6_global == doctest::Approx(one.order.psi6_global));
  CHECK(same.order.six_sided == one.order.six_sided);
}

TEST_CASE("point sets refuse what is none") {
  const Domain unit = Domain::periodic(Box::unit(2));
  Points<double> points(2, 3);
  points << 0, 0.5, 1, 0, 0.5, 1;
  CHECK(PointSet(points, unit).count() == 3);  // both faces included
  CHECK(message_of([&] { PointSet(points, Domain()); }).find("no box") != std::string::npos);
  CHECK(message_of([&] { PointSet(points, Domain::periodic(Box::unit(3))); }).find("3 dim") !=
        std::string::npos);
  CHECK(message_of([&] { PointSet(points.leftCols(1).eval(), unit); }).find("is one") !=
        std::string::npos);
  CHECK(message_of([&] { PointSet(points.leftCols(0).eval(), unit); }).find("none") !=
        std::string::npos);
  CHECK(message_of([&] { PointSet(Points<double>(0, 3), unit); }).find("no dim") !=
        std::string::npos);
  points(1, 2) = 1.5;
  CHECK(message_of([&] {
          PointSet(points, unit);
        }).find("coordinate 1 of point 2 is 1.5, outside the box") != std::string::npos);
  points(1, 2) = NAN;
  CHECK(message_of([&] { PointSet(points, unit); }).find("point 2 is nan") != std::string::npos);
  points.setConstant(0.25);
  CHECK(message_of([&] { PointSet(points, unit); }).find("all 3 of them are equal") !=
        std::string::npos);
}

TEST_SUITE_END();

}  // namespace ccvt::test
