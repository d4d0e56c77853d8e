// Spaces that are not a box with one unit: periodic along some dimensions, linear maps, regions.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/linear_map.h"
#include "ccvt/lloyd.h"
#include "ccvt/metrics.h"
#include "ccvt/problem.h"
#include "ccvt/region.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/generate.h"
#include "support/message.h"
#include "support/oracle.h"
#include "support/same.h"
#include "support/thread_ranks.h"

using ccvt::Box;
using ccvt::Domain;
using ccvt::Index;
using ccvt::LinearMap;
using ccvt::Points;
using ccvt::Problem;
using ccvt::Termination;
using namespace ccvt::test;

TEST_SUITE_BEGIN("spaces");

TEST_CASE_TEMPLATE("a box that is periodic along some dimensions", Scalar, float, double) {
  for (const int dimension : {2, 3, 5, 9}) {
    const Box box = uneven_box(dimension);
    const auto points = make_points<Scalar>(Layout::random, box, 700);
    for (int kind = 0; kind < 3; ++kind) {
      std::vector<bool> along(static_cast<std::size_t>(dimension), kind == 1);
      along[0] = kind != 1;
      along.back() = true;
      if (dimension == 2 && kind == 0) along[0] = false;
      if (kind == 2) along.assign(along.size(), false);
      CAPTURE(dimension);
      CAPTURE(kind);
      Problem<Scalar> problem(points, 23);
      problem.set_domain(Domain::periodic(box, along));
      const auto result = ccvt::tessellate(problem, {.seed = 3});
      CHECK(result.summary.termination == Termination::stable);
      CHECK(faults(problem, result) == "");
    }
  }
}

TEST_CASE("periodic along none is Euclidean, along all the torus, to the bit") {
  const Box box = uneven_box(3);
  const auto points = make_points<double>(Layout::random, box, 2000);
  Problem<double> a(points, 60);
  Problem<double> b(points, 60);
  for (const bool along : {false, true}) {
    a.set_domain(along ? Domain::periodic(box) : Domain::euclidean(box));
    b.set_domain(Domain::periodic(box, {along, along, along}));
    CHECK(differences(ccvt::tessellate(a), ccvt::tessellate(b)) == "");
  }
}

TEST_CASE("sites outside a box that is periodic along one dimension only are where they are") {
  const Box box = Box::unit(2);
  const Domain slab = Domain::periodic(box, {true, false});
  const auto points = make_points<double>(Layout::random, box, 400);
  for (const double y : {1.02, 1.5, 3.0, 100.0, -0.02, -0.5, -3.0}) {
    CAPTURE(y);
    Problem<double> problem(points, 20);
    problem.set_domain(slab);
    Points<double> fixed(2, 1);
    fixed << 0.5, y;
    problem.set_fixed_sites(fixed);
    const auto result = ccvt::tessellate(problem);
    CHECK(result.sites.col(0) == fixed.col(0));
    CHECK(result.summary.termination == Termination::stable);
    CHECK(faults(problem, result) == "");
    CHECK(ccvt::energy(points, result.sites, result.owners, slab) ==
          doctest::Approx(result.summary.energy).epsilon(1e-12));
    CHECK(ccvt::lloyd(problem, {.max_iterations = 5}).sites.col(0) == fixed.col(0));
    // The nearest of its points, not one that would be near on a torus.
    Points<double> moved = result.sites;
    const auto inside = [](std::span<const double> x) { return x[1] > 0 && x[1] < 1; };
    const auto put_back = ccvt::put_back(points, result.owners, moved, inside, slab);
    CHECK(put_back.sites == 1);
    CHECK(put_back.farthest > (y < 0 ? -y : y - 1));
    CHECK(put_back.farthest < (y < 0 ? 1 - y : y) + 0.5);
  }
}

TEST_CASE("a box far wider than its points, where it is not periodic, costs no digits") {
  const auto points = make_points<double>(Layout::random, Box::unit(2), 400);
  for (const double half : {2.0, 1e9, 1e13, 1e100}) {
    CAPTURE(half);
    Problem<double> problem(points, 20);
    problem.set_domain(Domain::periodic(Box{{0, -half}, {1, half}}, {true, false}));
    const auto result = ccvt::tessellate(problem);
    Problem<double> narrow(points, 20);
    narrow.set_domain(Domain::periodic(Box::unit(2), {true, false}));
    CHECK(faults(problem, result) == "");
    CHECK(result.summary.energy < 1.1 * ccvt::tessellate(narrow).summary.energy);
  }
}

TEST_CASE("many points a site, threads, and Lloyd's iterations in a tube") {
  const Box box{{0, 0}, {3, 1}};
  const auto points = ccvt::sample_uniform<double>(box, 40 * 2200, 6);
  Problem<double> problem(points, 40);
  problem.set_domain(Domain::periodic(box, {false, true}));
  const auto one = ccvt::tessellate(problem, {.threads = 1});
  CHECK(faults(problem, one) == "");
  CHECK(differences(one, ccvt::tessellate(problem, {.threads = 2})) == "");
  const auto flat = [&] {
    Problem<double> euclidean(points, 40);
    return ccvt::tessellate(euclidean);
  }();
  CHECK(one.summary.energy < flat.summary.energy);

  const auto lloyd = ccvt::lloyd(problem, {.max_iterations = 30});
  for (Index p = 0; p < 88000; p += 97) {
    const auto to = [&](Index s) {
      return squared_distance(problem.domain(), 2, points.col(p).data(), lloyd.sites.col(s).data());
    };
    Index nearest = 0;
    for (Index s = 1; s < 40; ++s) nearest = to(s) < to(nearest) ? s : nearest;
    const Index owner = lloyd.owners[static_cast<std::size_t>(p)];
    CHECK(to(owner) - to(nearest) < 0.02);  // owners are of the iteration before
  }
}

TEST_CASE("a cell goes round where the box is periodic, and only there") {
  // Four clumps at the corners: two sites.
  Points<double> points(2, 8);
  points << 0.1, 0.12, 0.9, 0.88, 0.1, 0.12, 0.9, 0.88,  //
      0.1, 0.12, 0.1, 0.12, 0.9, 0.88, 0.9, 0.88;
  Problem<double> problem(points, 2);
  problem.set_domain(Domain::periodic(Box::unit(2), {true, false}));
  const auto result = ccvt::tessellate(problem);
  CHECK(result.owners[0] == result.owners[2]);
  CHECK(result.owners[0] != result.owners[4]);
  CHECK(result.owners[4] == result.owners[6]);
}

TEST_CASE("domains that cannot be are refused") {
  CHECK(message_of([] {
          Domain::periodic(Box::unit(3), {true, false});
        }) == "along: has 2 entries, the box 3 dimensions: there must be one for each");
  const Domain slab = Domain::periodic(Box::unit(2), {true, false});
  CHECK(slab.is_periodic());
  CHECK(slab.is_partly_periodic());
  CHECK(!slab.is_periodic(1));
  const Points<double> points = ccvt::sample_uniform<double>(Box::unit(2), 10);
  CHECK(message_of([&] { ccvt::PointSet(points, slab); }) ==
        "domain: some dimensions are periodic and others are not: spectra are defined for all or "
        "none");
}

TEST_CASE("units: sites are those of the scaled problem") {
  const auto points = make_points<double>(Layout::random, uneven_box(3), 1000);
  const LinearMap map = LinearMap::units({1, 4, 0.5});
  const Points<double> mapped = map(points);
  CHECK(mapped.row(1) == 4 * points.row(1));
  CHECK(map.inverse(mapped) == points);  // powers of two
  const auto result = ccvt::tessellate(mapped, 30);
  const Points<double> sites = map.inverse(result.sites);
  for (Index s = 0; s < 30; ++s) {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    int count = 0;
    for (Index p = 0; p < 1000; ++p) {
      if (result.owners[static_cast<std::size_t>(p)] != s) continue;
      mean += points.col(p);
      ++count;
    }
    CHECK((mean / count - sites.col(s)).norm() < 1e-12);
  }
  const Domain domain = map(Domain::periodic(uneven_box(3), {true, false, true}));
  CHECK(domain.box().upper[1] == 4 * uneven_box(3).upper[1]);
  CHECK(domain.is_periodic(0));
  CHECK(!domain.is_periodic(1));
}

TEST_CASE("units: float points on the faces of a box have images in the box's image") {
  Points<float> points = ccvt::sample_uniform<float>(Box::unit(2), 50);
  points.col(0) << 0, 1;
  points.col(1) << 1, 0;
  const Domain torus = Domain::periodic(Box::unit(2));
  for (const double factor : {0.1, 0.7, -0.3, 1.0 / 3, 1e-20}) {
    Eigen::Matrix2d matrix;
    matrix << factor, 0, 0, 0.1;
    const LinearMap map = LinearMap::of(matrix, {0.2, -0.1});
    const Points<float> mapped = map(points);
    Problem<float> problem(mapped, 5);
    CHECK_NOTHROW(problem.set_domain(map.domain_of<float>(torus)));
  }
}

TEST_CASE("whitening: no linear map of the points changes who owns what") {
  // Whitened sets of linear images differ by a rotation only, up to rounding.
  const auto points = ccvt::sample_uniform<double>(Box::unit(2), 400, 8, ccvt::Distribution::white);
  Eigen::Matrix2d skew;
  skew << 3, 40, -0.2, 5;
  const Points<double> image = (skew * points).colwise() + Eigen::Vector2d(1e6, -3e5);
  const LinearMap map = LinearMap::whitening(image);
  const Points<double> white = map(image);
  const Eigen::Matrix2d covariance = white * white.transpose() / 400;
  CHECK((covariance - Eigen::Matrix2d::Identity()).norm() < 1e-9);
  CHECK(white.rowwise().mean().norm() < 1e-9);
  CHECK((map.inverse(white) - image).norm() < 1e-7);
  const Points<double> plain = LinearMap::whitening(points)(points);
  for (Index p = 1; p < 400; ++p) {
    CHECK((white.col(p) - white.col(0)).norm() ==
          doctest::Approx((plain.col(p) - plain.col(0)).norm()).epsilon(1e-8));
  }
}

TEST_CASE("whitening: of several ranks, to the bit that of one process") {
  constexpr Index kPoints = 10'000;  // in blocks of 4096, most of which several ranks share
  const auto cube =
      ccvt::sample_uniform<float>(Box::unit(3), kPoints, 8, ccvt::Distribution::white);
  const LinearMap alone = LinearMap::whitening(cube);
  const auto own_of = [&](const ccvt::Ranks& ranks) {
    // The second of three and more has none.
    const auto begin_of = [&](int rank) {
      if (rank == 2 && ranks.count() > 2) rank = 1;
      return kPoints * rank * rank / (ranks.count() * ranks.count());
    };
    const Index begin = begin_of(ranks.rank());
    return Points<float>(cube.middleCols(begin, begin_of(ranks.rank() + 1) - begin));
  };
  for (const int count : {1, 2, 3, 5}) {
    CAPTURE(count);
    std::atomic<int> same = 0;
    ThreadRanks(count).run([&](ccvt::Ranks& ranks) {
      const LinearMap map = LinearMap::whitening(ranks, own_of(ranks));
      same += map.matrix() == alone.matrix() && map.origin() == alone.origin() ? 1 : 0;
    });
    CHECK(same == count);
  }
  const auto messages = ccvt::test::messages_of(3, [&](ccvt::Ranks& ranks) {
    Points<float> own = own_of(ranks);
    if (ranks.rank() == 2) own(1, 5) = std::numeric_limits<float>::infinity();
    LinearMap::whitening(ranks, own);
  });
  CHECK(messages ==
        std::set<std::string>{"points: coordinate 1 of points[1116] is inf: it must be finite"});
  const auto flat = ccvt::test::messages_of(2, [&](ccvt::Ranks& ranks) {
    Points<float> own = own_of(ranks);
    own.row(1) = 2 * own.row(0);
    LinearMap::whitening(ranks, own);
  });
  REQUIRE(flat.size() == 1);
  CHECK(flat.begin()->find("points: their covariance is singular") == 0);
  CHECK(ccvt::test::messages_of(2, [](ccvt::Ranks& ranks) {
          LinearMap::whitening(ranks, Points<float>(2, 0));
        }) == std::set<std::string>{"points: there are none"});
  CHECK(ccvt::test::messages_of(2,
                                [](ccvt::Ranks& ranks) {
                                  const Points<float> own =
                                      Points<float>::Random(2 + ranks.rank(), 9);
                                  LinearMap::whitening(ranks, own);
                                }) ==
        std::set<std::string>{
            "points.dimension is 3 on rank 1, but 2 on rank 0: all ranks must be given the "
            "same"});
}

TEST_CASE("maps that cannot be are refused") {
  CHECK(message_of([] {
          LinearMap::units({1, 0});
        }) == "units[1] is 0: it must be positive and finite, and its inverse too");
  CHECK(message_of([] { LinearMap::of(Eigen::MatrixXd::Ones(2, 3)); }) ==
        "matrix: is 2 by 3: it must be square");
  CHECK(message_of([] { LinearMap::of(Eigen::MatrixXd::Ones(2, 2)); }) == "matrix: is singular");
  const Eigen::MatrixXd hilbert = Eigen::MatrixXd::NullaryExpr(
      10, 10, [](Eigen::Index i, Eigen::Index j) { return 1.0 / static_cast<double>(i + j + 1); });
  CHECK(message_of([&] {
          LinearMap::of(hilbert);
        }).find("matrix: is so nearly singular that mapping there and back is off by ") == 0);
  CHECK(message_of([] { LinearMap::units({1, 1e-320}); }).find("units[1] is ") == 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(message_of([&] {
          LinearMap::of(Eigen::Matrix2d{{1, nan}, {0, 1}});
        }) == "matrix(0, 1) is nan: it must be finite");
  CHECK(message_of([&] {
          LinearMap::of(Eigen::Matrix2d::Identity(), {1, nan});
        }) == "origin[1] is nan: it must be finite");
  CHECK(message_of([] { LinearMap::of(Eigen::Matrix2d::Identity(), {1}); }) ==
        "origin: has 1 coordinates, the matrix 2 columns: there must be one for each");
  Points<double> unknown = Points<double>::Random(2, 9);
  unknown(1, 4) = nan;
  CHECK(message_of([&] { LinearMap::whitening(unknown); }) ==
        "points: coordinate 1 of points[4] is nan: it must be finite");
  Points<double> line(2, 50);
  for (Index p = 0; p < 50; ++p) line.col(p) << p, 2 * p;
  CHECK(message_of([&] { LinearMap::whitening(line); }).find("points: their covariance is") == 0);
  Eigen::Matrix2d turn;
  turn << 1, 1, -1, 1;
  const LinearMap turned = LinearMap::of(turn);
  CHECK(message_of([&] {
          (void)turned(Domain::periodic(Box::unit(2)));
        }).find("domain: has a box") == 0);
  const Points<double> others = Points<double>::Zero(3, 2);
  CHECK(message_of([&] { turned(others); }) ==
        "points: have 3 dimensions, the map has 2: the two must be equal");
  const LinearMap huge = LinearMap::units({1e30, 1e30});
  const Points<float> large = Points<float>::Constant(2, 1, 1e20F);
  CHECK(message_of([&] { huge(large); }) ==
        "points: coordinate 0 of points[0] is mapped to inf: it must be finite");
}

TEST_CASE("regions with holes: no sample lies in one") {
  const auto ring = [](std::span<const double> x) {
    const double r = std::hypot(x[0], x[1]);
    return r > 0.8 && r < 1;
  };
  const Box box{{-1, -1}, {1, 1}};
  const auto points = ccvt::sample_region<double, 2>(ring, box, 20 * 512, 3);
  auto result = ccvt::tessellate(points, 20, ccvt::Options::samples());
  // Few sites: cells are bent. Those of three sites would have centroids in the hole.
  auto few = ccvt::tessellate(points, 3);
  const ccvt::PutBack moved = ccvt::put_back(points, few.owners, few.sites, ring);
  CHECK(moved.sites == 3);
  for (Index s = 0; s < 3; ++s) {
    const Eigen::Vector2d site = few.sites.col(s);
    CHECK(ring({site.data(), 2}));
    bool own = false;
    for (Index p = 0; p < points.cols(); ++p) {
      own = own || (few.owners[static_cast<std::size_t>(p)] == s && points.col(p) == site);
    }
    CHECK(own);
  }
  CHECK(moved.farthest > 0.05);
  CHECK(ccvt::put_back(points, result.owners, result.sites, ring).sites == 0);
  for (Index p = 0; p < points.cols(); ++p) CHECK(ring({points.col(p).data(), 2}));
  // Even: as many points on each side.
  CHECK(std::abs((points.row(0).array() > 0).count() - 10 * 512) < 64);
}

TEST_CASE("put_back refuses what does not agree") {
  const Points<double> points = Points<double>::Zero(2, 3);
  Points<double> sites = Points<double>::Zero(2, 2);
  const auto nowhere = [](std::span<const double>) { return false; };
  CHECK(message_of([&] {
          ccvt::put_back(points, std::vector<Index>{0, 1}, sites, nowhere);
        }) == "owners: there are 2 for 3 points: there must be one per point");
  CHECK(message_of([&] {
          ccvt::put_back(points, std::vector<Index>{0, 1, 2}, sites, nowhere);
        }) == "owners[2] is 2: it must be in 0..1");
  CHECK(message_of([&] {
          ccvt::put_back(points, std::vector<Index>{0, 1, 1}, sites, {});
        }) == "region: is empty, but must be callable");
  CHECK(message_of([&] { ccvt::sample_region({}, Box::unit(2), 4); }) ==
        "region: is empty, but must be callable");
  CHECK(message_of([&] {
          ccvt::sample_region(nowhere, Box::unit(2), 4);
        }).find("region: has no points in the box") == 0);
  Points<double> none(2, 0);
  CHECK(message_of([&] {
          ccvt::put_back(points, std::vector<Index>{0, 0, 0}, none, nowhere);
        }) == "sites: there are none");
  const Points<double> flat(0, 3);
  Points<double> flat_sites(0, 2);
  CHECK(message_of([&] {
          ccvt::put_back(flat, std::vector<Index>{0, 1, 1}, flat_sites, nowhere);
        }) == "points: they have no dimension");
  auto lost = sites;
  lost(1, 1) = std::numeric_limits<double>::quiet_NaN();
  CHECK(message_of([&] {
          ccvt::put_back(points, std::vector<Index>{0, 1, 1}, lost, nowhere);
        }).find("sites: coordinate 1 of sites[1] is nan") == 0);
  auto missing = points;
  missing(0, 2) = std::numeric_limits<double>::infinity();
  CHECK(message_of([&] {
          ccvt::put_back(missing, std::vector<Index>{0, 1, 1}, sites, nowhere);
        }).find("points: coordinate 0 of points[2] is inf") == 0);
  // A site without points stays, and is not counted.
  CHECK(ccvt::put_back(points, std::vector<Index>{0, 0, 0}, sites, nowhere).sites == 1);
}

TEST_SUITE_END();
