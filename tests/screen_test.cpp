#include "relax/screen.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "random.h"
#include "relax/update.h"
#include "support/thread_ranks.h"

using ccvt::Arena;
using ccvt::Buffer;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::Pair;
using ccvt::PointOfAll;
using ccvt::Random;
using ccvt::Screen;
using ccvt::SiteNumber;
using ccvt::sites_below;
using ccvt::SiteState;
using ccvt::Tiling;

namespace {

/// Cells of points in clouds far apart, which change as relaxing changes them, but by chance.
template <class Scalar>
struct Changing {
  Changing(int dimension, std::size_t count, Index size, double scale, std::uint64_t seed)
      : metric(dimension, Domain()),
        tiling(count, 1),
        cells(dimension, std::vector<Index>(count, size)),
        sites(dimension, count),
        touched(count, 1),
        random(seed, 1) {
    std::vector<Scalar> point(cells.dimension());
    Index number = 0;
    for (const SiteNumber s : sites.all()) {
      const double cloud = 30 * static_cast<double>(s.index() % 5);
      for (Index k = 0; k < cells.size(s); ++k) {
        for (Scalar& x : point) x = static_cast<Scalar>(scale * (cloud + random.uniform()));
        cells.put(s, k, PointOfAll(number++), point.data());
      }
    }
    move(sites_below(count));
  }

  template <class Range>
  void move(const Range& range) {
    for (const SiteNumber s : range) {
      sites.radius[s] = std::numeric_limits<double>::infinity();
      update_site(metric, cells, sites, s);
    }
  }

  /// Exchanges a point of one cell with one of another, then moves both sites.
  void exchange(SiteNumber i, SiteNumber j) {
    const Index k = random.index_below(cells.size(i));
    const Index l = random.index_below(cells.size(j));
    std::vector<Scalar> a(cells.dimension());
    std::vector<Scalar> b(cells.dimension());
    cells.get(i, k, a.data());
    cells.get(j, l, b.data());
    const PointOfAll p = cells.point(i, k);
    cells.put(i, k, cells.point(j, l), b.data());
    cells.put(j, l, p, a.data());
    touched[i] = touched[j] = 1;
    move(std::vector<SiteNumber>{i, j});
  }

  [[nodiscard]] double reach(SiteNumber i, SiteNumber j) const {
    std::vector<Scalar> point(cells.dimension());
    double largest = -std::numeric_limits<double>::infinity();
    for (Index k = 0; k < cells.size(i); ++k) {
      cells.get(i, k, point.data());
      double difference = 0;
      for (std::size_t d = 0; d < point.size(); ++d) {
        const double x = point[d];
        difference += std::pow(x - sites.at(i)[d], 2) - std::pow(x - sites.at(j)[d], 2);
      }
      largest = std::max(largest, difference);
    }
    return largest;
  }

  Metric metric;
  Tiling tiling;
  Cells<Scalar> cells;
  SiteState sites;
  std::vector<std::uint8_t> touched;
  Random random;
};

struct Shape {
  int dimension;
  std::size_t sites;
  Index size;
  double scale;
};

std::vector<Pair> listed(const Buffer<Pair>& pairs) { return {pairs.begin(), pairs.end()}; }

}  // namespace

TEST_SUITE_BEGIN("screen");

TEST_CASE_TEMPLATE("screen: what is kept finds the pairs that a new screen finds, all that gain",
                   Scalar, float, double) {
  for (const Shape& shape :
       {Shape{7, 2, 3, 1}, Shape{8, 60, 2, 1}, Shape{16, 141, 9, 1}, Shape{20, 65, 40, 1e-3},
        Shape{9, 70, 5, 1e6}, Shape{9, 70, 5, 1e13}, Shape{9, 70, 5, 1e18}, Shape{16, 50, 4, 1e20},
        Shape{9, 40, 3, 1e100}, Shape{9, 40, 3, 1e-25}}) {
    // Coordinates are some hundred times the scale: see scales.h. Beyond 1e19 some products of
    // floats overflow, though these are doubles.
    if (std::is_same_v<Scalar, float> && shape.scale > 1e13) continue;
    CAPTURE(shape.dimension);
    CAPTURE(shape.scale);
    Changing<Scalar> state(shape.dimension, shape.sites, shape.size, shape.scale, 11);
    const Arena one(1);
    const Arena three(3);
    Screen<Scalar> kept(state.metric);
    const auto n = static_cast<Index>(shape.sites);
    std::size_t most = 0;
    std::size_t least = shape.sites * shape.sites;
    for (int pass = 0; pass < 12; ++pass) {
      const auto pairs =
          listed(kept.gaining(state.cells, state.sites, state.touched, state.tiling, three));
      const auto anew =
          listed(Screen<Scalar>(state.metric)
                     .gaining(state.cells, state.sites, state.touched, state.tiling, one));
      CHECK(pairs == anew);
      for (const SiteNumber i : state.sites.all()) {
        for (const SiteNumber j : state.sites.all().after(i)) {
          if ((state.touched[i] | state.touched[j]) == 0) continue;
          if (state.reach(i, j) + state.reach(j, i) <= 0) continue;
          const bool found = std::binary_search(pairs.begin(), pairs.end(), Pair(i, j));
          CHECK(found);
        }
      }
      most = std::max(most, pairs.size());
      least = std::min(least, pairs.size());
      std::fill(state.touched.begin(), state.touched.end(), std::uint8_t{0});
      if (pass == 5) {  // as after a pass that was left
        kept.forget();
        std::fill(state.touched.begin(), state.touched.end(), std::uint8_t{1});
      }
      const int exchanges = pass % 4 == 3 ? 0 : pass % 4 == 2 ? 2 : n;
      for (int e = 0; e < exchanges; ++e) {
        const Index i = state.random.index_below(n);
        const Index j = (i + 1 + state.random.index_below(n - 1)) % n;
        state.exchange(SiteNumber(i), SiteNumber(j));
      }
    }
    CHECK(least < most);  // they are not all the same
  }
}

TEST_CASE_TEMPLATE("screen: ranks, each with its own cells only, find what one process finds",
                   Scalar, float, double) {
  for (const Shape& shape : {Shape{7, 5, 3, 1}, Shape{8, 60, 2, 1}, Shape{16, 141, 9, 1},
                             Shape{9, 70, 5, 1e6}, Shape{9, 40, 3, 1e-25}}) {
    for (const int count : {1, 2, 3}) {
      CAPTURE(shape.dimension);
      CAPTURE(count);
      std::vector<std::size_t> found(static_cast<std::size_t>(count), 0);
      std::vector<std::size_t> wrong(found.size(), 0);
      ThreadRanks(count).run([&](ccvt::Ranks& ranks) {
        const auto rank = static_cast<std::size_t>(ranks.rank());
        Changing<Scalar> state(shape.dimension, shape.sites, shape.size, shape.scale, 11);
        Tiling tiling(shape.sites, 3);
        tiling.deal(ranks, state.cells.sizes());
        const Arena arena(1 + ranks.rank());
        Screen<Scalar> kept(state.metric);
        Screen<Scalar> forgetful(state.metric, 0);
        for (int pass = 0; pass < 10; ++pass) {
          Cells<Scalar> own = state.cells;
          const std::vector<Scalar> nowhere(own.dimension(),
                                            std::numeric_limits<Scalar>::quiet_NaN());
          for (const SiteNumber s : own.sites()) {
            if (tiling.is_own(tiling.tile_of(s))) continue;
            for (Index k = 0; k < own.size(s); ++k) own.put(s, k, own.point(s, k), nowhere.data());
          }
          const auto pairs = listed(kept.gaining(own, state.sites, state.touched, tiling, arena));
          const auto alone =
              listed(Screen<Scalar>(state.metric)
                         .gaining(state.cells, state.sites, state.touched, state.tiling, arena));
          const auto anew =
              listed(forgetful.gaining(own, state.sites, state.touched, tiling, arena));
          wrong[rank] += pairs == alone && anew == alone ? 0 : 1;
          found[rank] += pairs.size();
          if (pass == 6) kept.forget();
          std::fill(state.touched.begin(), state.touched.end(), std::uint8_t{0});
          const auto n = static_cast<Index>(shape.sites);
          for (Index k = 0; k < 1 + n / 8; ++k) {
            const SiteNumber i(state.random.index_below(n));
            const SiteNumber j(state.random.index_below(n));
            if (i != j) state.exchange(i, j);
          }
        }
      });
      CHECK(std::count(wrong.begin(), wrong.end(), 0) == count);
      for (const std::size_t pairs : found) CHECK(pairs > 10);
    }
  }
}

TEST_SUITE_END();
