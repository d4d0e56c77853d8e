// Points along a curve, and subsets that are spread evenly over them.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <initializer_list>
#include <numeric>
#include <span>
#include <string>
#include <vector>

#include "ccvt/domain.h"
#include "parallel/arena.h"
#include "random.h"
#include "relax/along_curve.h"
#include "relax/levels.h"
#include "relax/own_points.h"
#include "relax/subsets.h"
#include "support/generate.h"
#include "support/thread_ranks.h"

using ccvt::Arena;
using ccvt::Box;
using ccvt::Index;
using ccvt::NestedSubsets;
using ccvt::OwnPoints;
using ccvt::PointNumber;
using ccvt::Points;
using ccvt::PointsAlongCurve;
using ccvt::PointsView;
using ccvt::Ranks;
using ccvt::test::Layout;

namespace {

NestedSubsets even_subsets(std::uint64_t seed, std::size_t places,
                           std::span<const std::size_t> sizes, const Arena& arena) {
  return {NestedSubsets::Order::even, ccvt::Random(seed), places, sizes, arena};
}

/// By point; `along` has those of one process or rank.
template <class Scalar>
std::vector<std::size_t> places_of(PointsAlongCurve<Scalar> along, const Arena& arena) {
  std::vector<std::size_t> places(along.own_count());
  along.for_each(arena, [&](PointNumber p, std::size_t place) { places[p] = place; });
  return places;
}

template <class Scalar>
PointsView<Scalar> part_of(const Points<Scalar>& points, Index first, Index count) {
  const auto dimension = static_cast<int>(points.rows());
  return {points.data() + std::ptrdiff_t{first} * dimension, dimension, count, dimension};
}

template <class Scalar>
std::vector<std::size_t> places_of_all(const Points<Scalar>& points, const Box& box,
                                       const Arena& arena = Arena(1)) {
  const auto count = static_cast<Index>(points.cols());
  const OwnPoints<Scalar> own(part_of(points, 0, count));
  return places_of(PointsAlongCurve<Scalar>(own, count, box, arena), arena);
}

/// How many of the first places are in a subset, less as many as its share of them.
double most_off(const NestedSubsets& subsets, std::size_t subset, std::size_t size,
                std::size_t places) {
  const double share = static_cast<double>(size) / static_cast<double>(places);
  double off = 0;
  double most = 0;
  for (std::size_t p = 0; p < places; ++p) {
    off += (subsets.smallest_with(p) <= subset ? 1 : 0) - share;
    most = std::max(most, std::abs(off));
  }
  return most;
}

}  // namespace

TEST_SUITE_BEGIN("even subsets");

TEST_CASE("subsets of places are exact, nested and the same for any threads and ranks") {
  for (const std::size_t places :
       std::initializer_list<std::size_t>{1, 2, 3, 1000, 65536, 300000}) {
    CAPTURE(places);
    std::vector<std::size_t> sizes;
    for (const std::size_t divisor : std::initializer_list<std::size_t>{1000, 16, 7, 4, 1}) {
      if (places >= divisor) sizes.push_back(places / divisor);
    }
    const NestedSubsets subsets = even_subsets(7, places, sizes, Arena(1));
    std::vector<std::size_t> expected;
    std::vector<std::size_t> members(sizes.size(), 0);
    for (std::size_t p = 0; p < places; ++p) {
      expected.push_back(subsets.smallest_with(p));
      for (std::size_t s = expected.back(); s < sizes.size(); ++s) ++members[s];
    }
    CHECK(members == sizes);
    const auto found = [&](const NestedSubsets& other) {
      std::vector<std::size_t> smallest;
      for (std::size_t p = 0; p < places; ++p) smallest.push_back(other.smallest_with(p));
      return smallest;
    };
    CHECK(found(even_subsets(7, places, sizes, Arena(3))) == expected);
    ThreadRanks(3).run([&](Ranks& ranks) {
      Arena arena(1);
      arena.divide_among(&ranks);
      CHECK(found(even_subsets(7, places, sizes, arena)) == expected);
    });
    if (places >= 1000) CHECK(found(even_subsets(8, places, sizes, Arena(1))) != expected);
  }
  CHECK(even_subsets(7, 10, {}, Arena(1)).smallest_with(3) == 0);
}

TEST_CASE("a subset has its share of any run of places, but for a few") {
  for (const std::size_t places : std::initializer_list<std::size_t>{4096, 100000, 131072}) {
    CAPTURE(places);
    const std::array<std::size_t, 4> sizes{places / 1000, places / 64, places / 7, places / 4};
    for (const std::uint64_t seed : std::initializer_list<std::uint64_t>{1, 2, 3}) {
      const NestedSubsets subsets = even_subsets(seed, places, sizes, Arena(1));
      for (std::size_t s = 0; s < sizes.size(); ++s) {
        CAPTURE(s);
        // Drawn one by one, they would be off by about the root of the size.
        CHECK(most_off(subsets, s, sizes[s], places) < std::log2(static_cast<double>(places)) / 2);
      }
    }
  }
  // Of runs of four that begin at a multiple of it, one each.
  const std::array<std::size_t, 1> quarter{1 << 14};
  const NestedSubsets subsets = even_subsets(5, 1 << 16, quarter, Arena(1));
  std::array<int, 4> which{};
  for (std::size_t run = 0; run < quarter[0]; ++run) {
    int in = 0;
    for (std::size_t k = 0; k < 4; ++k) {
      if (subsets.smallest_with(4 * run + k) > 0) continue;
      ++in;
      ++which[k];
    }
    REQUIRE(in == 1);
  }
  // As likely the one as the other: mean 4096, standard deviation 55.
  for (const int count : which) CHECK(std::abs(count - (1 << 12)) < 5 * 55);
}

TEST_CASE_TEMPLATE("places along the curve are those of any threads and ranks", Scalar, float,
                   double) {
  for (const int dimension : {1, 2, 3, 20}) {
    CAPTURE(dimension);
    const Box box = Box::unit(dimension);
    for (const Layout layout : {Layout::random, Layout::clusters}) {
      const Index count = 20000;
      Points<Scalar> points = ccvt::test::make_points<Scalar>(layout, box, count, 3);
      points.col(17) = points.col(4);
      const std::vector<std::size_t> expected = places_of_all(points, box);
      std::vector<std::size_t> sorted = expected;
      std::sort(sorted.begin(), sorted.end());
      std::vector<std::size_t> all(sorted.size());
      std::iota(all.begin(), all.end(), std::size_t{0});
      CHECK(sorted == all);
      CHECK(places_of_all(points, box, Arena(3)) == expected);
      // In as many runs as many workers would count.
      ccvt::Recorder recorder;
      recorder.listen([](const ccvt::Recorder::Loop&) {});
      CHECK(places_of_all(points, box, Arena(1, nullptr, &recorder)) == expected);
      // One rank has none.
      const std::vector<Index> counts{5000, 0, 1, 12999, 2000};
      std::vector<std::vector<std::size_t>> found(counts.size());
      ThreadRanks(5).run([&](Ranks& ranks) {
        Arena arena(1 + ranks.rank() % 2);  // points in one run, and in two
        arena.divide_among(&ranks);
        const auto r = static_cast<std::size_t>(ranks.rank());
        const Index first = std::accumulate(counts.begin(), counts.begin() + ranks.rank(), 0);
        const OwnPoints<Scalar> own(part_of(points, first, counts[r]), first);
        found[r] = places_of(PointsAlongCurve<Scalar>(own, count, box, arena), arena);
      });
      std::vector<std::size_t> together;
      for (const auto& of_rank : found) {
        together.insert(together.end(), of_rank.begin(), of_rank.end());
      }
      CHECK(together == expected);
    }
  }
}

TEST_CASE("points that follow each other along the curve are near each other") {
  const Box box = Box::unit(2);
  const Index count = 1 << 14;
  const Points<double> points = ccvt::test::make_points<double>(Layout::random, box, count, 5);
  const std::vector<std::size_t> place = places_of_all(points, box);
  std::vector<Index> order(place.size());
  for (std::size_t p = 0; p < place.size(); ++p) order[place[p]] = static_cast<Index>(p);
  double sum = 0;
  for (std::size_t k = 1; k < order.size(); ++k) {
    sum += (points.col(order[k]) - points.col(order[k - 1])).norm();
  }
  // In units of the distance of points in a square lattice; of points in any order, 67.
  CHECK(sum / count * std::sqrt(count) < 3);
}

TEST_CASE("points in one place, or far outside the box, have places all the same") {
  Points<float> points = Points<float>::Constant(2, 1000, 0.25F);
  std::vector<std::size_t> expected(1000);
  std::iota(expected.begin(), expected.end(), std::size_t{0});
  const Box point{points.col(0).cast<double>(), points.col(0).cast<double>()};
  CHECK(places_of_all(points, point) == expected);
  CHECK(places_of_all(points, Box::unit(2)) == expected);
  points.row(0).setConstant(1e30F);
  CHECK(places_of_all(points, Box::unit(2)) == expected);
}

TEST_CASE("clouds have their share of every level") {
  // Two clouds, three quarters of the points in one of them, in no order.
  const Index count = 1 << 16;
  ccvt::Random random(4);
  Points<double> points(2, count);
  std::vector<std::uint8_t> small(static_cast<std::size_t>(count));
  for (Index p = 0; p < count; ++p) {
    small[static_cast<std::size_t>(p)] = random.uniform() < 0.25 ? 1 : 0;
    const double middle = small[static_cast<std::size_t>(p)] != 0 ? 10 : 0;
    points.col(p) << middle + random.uniform(), random.uniform();
  }
  const auto share = std::accumulate(small.begin(), small.end(), 0.0) / count;
  ccvt::Options options;
  std::vector<ccvt::Level> levels = ccvt::make_levels(std::vector<Index>(64, count / 64), options);
  REQUIRE(levels.size() == 4);
  const Box box{Eigen::Vector2d(0, 0), Eigen::Vector2d(11, 1)};
  PointsAlongCurve<double> along(OwnPoints<double>(part_of(points, 0, count)), count, box,
                                 Arena(1));
  ccvt::share_points(levels, along, 0, options.seed, Arena(1));
  std::size_t joined = 0;
  int of_small = 0;
  for (const ccvt::Level& level : levels) {
    for (const PointNumber p : level.joining.all()) of_small += small[p];
    joined += level.joining.size();
    // Drawn one by one, the coarsest would be off by 14, as its standard deviation.
    CHECK(std::abs(of_small - share * static_cast<double>(joined)) < 3);
  }
}

TEST_CASE("ranks share the points among levels as one process does") {
  // Blocks of points that are of two and three ranks, and of one.
  const std::vector<Index> counts{70000, 5, 100000, 40000};
  const Index count = ccvt::test::sum_of(counts);
  const Box box = Box::unit(2);
  const auto points = ccvt::test::make_points<float>(Layout::clusters, box, count, 6);
  const std::vector<Index> capacities(5, count / 5);
  const ccvt::Options options;
  std::vector<ccvt::Level> expected = ccvt::make_levels(capacities, options);
  REQUIRE(expected.size() > 3);
  PointsAlongCurve<float> all_points(OwnPoints<float>(part_of(points, 0, count)), count, box,
                                     Arena(2));
  ccvt::share_points(expected, all_points, 0, options.seed, Arena(2));
  std::vector<std::vector<std::vector<Index>>> found(counts.size());
  ThreadRanks(4).run([&](Ranks& ranks) {
    Arena arena(1 + ranks.rank() % 2);
    arena.divide_among(&ranks);
    const auto r = static_cast<std::size_t>(ranks.rank());
    const Index first = std::accumulate(counts.begin(), counts.begin() + ranks.rank(), 0);
    PointsAlongCurve<float> along(OwnPoints<float>(part_of(points, first, counts[r]), first), count,
                                  box, arena);
    std::vector<ccvt::Level> levels = ccvt::make_levels(capacities, options);
    ccvt::share_points(levels, along, static_cast<std::size_t>(first), options.seed, arena);
    for (ccvt::Level& level : levels) {
      level.joining.keep_own(static_cast<std::size_t>(first),
                             static_cast<std::size_t>(first) + static_cast<std::size_t>(counts[r]));
      std::vector<Index>& own = found[r].emplace_back();
      for (const PointNumber p : level.joining.all()) own.push_back(first + p.index());
      std::vector<Index> in_parts;
      level.joining.for_own_parts(1, 1, arena, [&](std::span<const PointNumber> part) {
        for (const PointNumber p : part) in_parts.push_back(first + p.index());
      });
      CHECK(in_parts == own);
    }
  });
  for (std::size_t l = 0; l < expected.size(); ++l) {
    CAPTURE(l);
    std::vector<Index> together;
    for (const auto& of_rank : found) {
      together.insert(together.end(), of_rank[l].begin(), of_rank[l].end());
    }
    std::vector<Index> all;
    for (const PointNumber p : expected[l].joining.all()) all.push_back(p.index());
    CHECK(together == all);
    CHECK(all.size() == expected[l].joining.size());
  }
}

TEST_SUITE_END();
