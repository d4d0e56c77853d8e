// What is known of pairs that are apart, against all points of both cells.
#include "relax/apart.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "kernels/keys.h"
#include "random.h"
#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Apart;
using ccvt::Box;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Metric;
using ccvt::PairCut;
using ccvt::Patches;
using ccvt::PointOfAll;
using ccvt::Random;
using ccvt::SiteNumber;
using ccvt::SiteState;
using namespace ccvt::test;

namespace {

constexpr SiteNumber site_i(0);
constexpr SiteNumber site_j(1);
constexpr Index kSmall = 40;

/// Points on their sides of a plane: a large cell, and beside it a small one.
template <class Scalar>
struct Neighbours {
  Neighbours(const Metric& its_metric, double size, double origin, bool large_is_i)
      : metric(its_metric),
        scale(size),
        from(origin),
        large(large_is_i ? site_i : site_j),
        small(large_is_i ? site_j : site_i),
        cells(metric.dimension(), large_is_i ? std::vector<Index>{large_size(), kSmall}
                                             : std::vector<Index>{kSmall, large_size()}),
        sites(metric.dimension(), 2),
        patches(metric.dimension(), cells.sizes()),
        cut(metric, std::abs(origin) + 1) {
    begin();
    typename Patches<Scalar>::Scratch scratch;
    for (int look = 0; look < 64; ++look) {
      for (const SiteNumber s : cells.sites()) patches.look(cells, s, scratch);
    }
    REQUIRE(patches.has(large));
    REQUIRE_FALSE(patches.has(small));
  }

  [[nodiscard]] Index large_size() const {
    return metric.dimension() == 1 ? 500 : metric.dimension() == 2 ? 4000 : 29000;
  }

  /// New points for all places, and sites on both sides of the plane.
  void begin() {
    for (int d = 0; d < metric.dimension(); ++d) {
      const double from_cut = d == 0 ? 0.05 + 0.25 * random.uniform() : 0;
      const double on_cut = d == 0 ? 0.6 : 0.3 + 0.4 * random.uniform();
      sites.at(large)[d] = placed(on_cut - from_cut, d);
      sites.at(small)[d] = placed(on_cut + from_cut, d);
    }
    for (const SiteNumber s : cells.sites()) {
      sites.radius[s] = 0;
      sites.compact[s] = 1;
      for (Index k = 0; k < cells.size(s); ++k) put(s, k, s == large ? 0.58 * random.uniform() : 0);
    }
  }

  /// Where a share of the size is along a dimension.
  [[nodiscard]] double placed(double share, int d) const {
    const double x = from + scale * share;
    return metric.periodic() && x >= metric.extent()[d] ? x - metric.extent()[d] : x;
  }

  /// All points in three places: most of the large cell in one, some in one beside the small cell,
  /// all of that in one; its site between the two.
  void begin_worst(double beside) {
    place(large, 0.45, 0.36);
    place(small, 0.55, 0.36);
    for (const SiteNumber s : cells.sites()) {
      for (Index k = 0; k < cells.size(s); ++k) {
        if (s == small) put_near(s, k, 0.6, 0.446);
        if (s == large && k < beside) put_near(s, k, 0.4, 0.1);
        if (s == large && k >= beside) put_near(s, k, 0.3, 0.36);
      }
      measure(s);
    }
  }
  void put_near(SiteNumber s, Index place, double x, double y) {
    const auto some = [&] { return 1e-3 * random.uniform(); };
    replace(
        s, place,
        {static_cast<Scalar>(placed(x + some(), 0)), static_cast<Scalar>(placed(y + some(), 1))});
  }

  /// Both cells far from the cut, and all points of each in one place.
  void begin_far() {
    for (const SiteNumber s : cells.sites()) {
      const double x = s == large ? 0.1 : 0.85;
      place(s, x, 0.5);
      for (Index k = 0; k < cells.size(s); ++k) put_near(s, k, x, 0.5);
      measure(s);
    }
  }
  void place(SiteNumber s, double x, double y) {
    sites.at(s)[0] = placed(x, 0);
    sites.at(s)[1] = placed(y, 1);
    measure(s);
  }
  /// A point on the cut, so far along it, but for rounding.
  void put_on_cut(SiteNumber s, Index place, double along) {
    const double x = sites.at(small)[0] - sites.at(large)[0];
    const double y = sites.at(small)[1] - sites.at(large)[1];
    const double length = std::hypot(x, y);
    const double middle_x = (sites.at(small)[0] + sites.at(large)[0]) / 2;
    const double middle_y = (sites.at(small)[1] + sites.at(large)[1]) / 2;
    replace(s, place,
            {static_cast<Scalar>(middle_x - along * y / length),
             static_cast<Scalar>(middle_y + along * x / length)});
  }

  /// Another point at a place of a cell, `along` from the far end of the large cell, where the
  /// small cell begins at .6.
  void put(SiteNumber s, Index place, double along) {
    std::vector<Scalar> x;
    for (int d = 0; d < metric.dimension(); ++d) {
      const double uniform = random.uniform();
      const double in_large = d == 0 ? along : uniform;
      const double in_small = d == 0 ? 0.62 + 0.3 * uniform : 0.4 + 0.2 * uniform;
      x.push_back(static_cast<Scalar>(placed(s == large ? in_large : in_small, d)));
    }
    replace(s, place, x);
  }
  void replace(SiteNumber s, Index place, const std::vector<Scalar>& x) {
    const std::vector<Scalar> left = point(s, place);
    cells.put(s, place, PointOfAll(place), x.data());
    patches.replace(s, place, x.data(), left.data());
    grow(s, x.data());
  }
  void grow(SiteNumber s, const Scalar* x) {
    const double distance = std::sqrt(metric.squared_distance(x, sites.at(s)));
    sites.radius[s] = std::max(sites.radius[s], distance * (1 + 1e-12));
    for (int d = 0; d < metric.dimension(); ++d) {
      const double by = x[d] - sites.at(s)[d];
      if (metric.wrap(by, d) != by) sites.compact[s] = 0;
    }
  }

  /// Moves both sites, each coordinate by up to so much of the size.
  void move(double most) {
    for (const SiteNumber s : cells.sites()) {
      for (int d = 0; d < metric.dimension(); ++d) {
        sites.at(s)[d] += scale * most * (2 * random.uniform() - 1);
      }
      measure(s);
    }
  }
  void measure(SiteNumber s) {
    sites.radius[s] = 0;
    sites.compact[s] = 1;
    for (Index k = 0; k < cells.size(s); ++k) grow(s, point(s, k).data());
  }
  [[nodiscard]] std::vector<Scalar> point(SiteNumber s, Index k) const {
    std::vector<Scalar> x(static_cast<std::size_t>(metric.dimension()));
    cells.get(s, k, x.data());
    return x;
  }

  /// Moves both sites as little as makes an exchange gain, and a hundredth more. Not on a torus.
  void move_worst() {
    Real least = std::numeric_limits<Real>::infinity();  // both together
    std::vector<Real> direction;                         // of the small cell's site
    const auto dimension = static_cast<std::size_t>(metric.dimension());
    for (Index l = 0; l < cells.size(large); ++l) {
      const std::vector<Scalar> q = point(large, l);
      for (Index k = 0; k < cells.size(small); ++k) {
        const std::vector<Scalar> p = point(small, k);
        Real gap = 0;
        Real squared = 0;
        for (std::size_t d = 0; d < dimension; ++d) {
          const Real by = static_cast<Real>(q[d]) - static_cast<Real>(p[d]);
          gap -=
              by * (static_cast<Real>(sites.at(small)[d]) - static_cast<Real>(sites.at(large)[d]));
          squared += by * by;
        }
        const Real length = std::sqrt(squared);
        if (gap / length >= least) continue;
        least = gap / length;
        direction.clear();
        for (std::size_t d = 0; d < dimension; ++d) {
          direction.push_back((static_cast<Real>(q[d]) - static_cast<Real>(p[d])) / length);
        }
      }
    }
    const Real share = random.uniform();
    for (std::size_t d = 0; d < dimension; ++d) {
      const Real by = 1.01L * least * direction[d];
      sites.at(small)[d] += static_cast<double>(share * by);
      sites.at(large)[d] -= static_cast<double>((1 - share) * by);
    }
    measure(large);
    measure(small);
  }

  /// Whether no exchange gains, by all points.
  [[nodiscard]] bool apart(const Domain& domain) const {
    Real highest = -std::numeric_limits<Real>::infinity();
    Real lowest = -highest;
    for (const SiteNumber s : cells.sites()) {
      for (Index k = 0; k < cells.size(s); ++k) {
        const std::vector<Scalar> x = point(s, k);
        const Real key = squared_distance(domain, metric.dimension(), x.data(), sites.at(large)) -
                         squared_distance(domain, metric.dimension(), x.data(), sites.at(small));
        if (s == large) highest = std::max(highest, key);
        if (s == small) lowest = std::min(lowest, key);
      }
    }
    return highest <= lowest;
  }

  typename Apart<Scalar>::Pair pair() {
    cut.place(sites, site_i, site_j);
    return {metric, cut, cells, patches, sites, site_i, site_j};
  }

  /// Gives it the `most` points of the large cell that are nearest to the small one.
  void note(Apart<Scalar>& known, std::size_t most) {
    const auto its_pair = pair();
    const bool is_i = large == site_i;
    const auto side = is_i ? PairCut<Scalar>::Side::i : PairCut<Scalar>::Side::j;
    std::vector<Scalar> keys(static_cast<std::size_t>(cells.size(large)));
    ccvt::kernels::keys(cells.block(large), cells.size(large), metric.dimension(),
                        cut.straight_cut(side), keys.data());
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < keys.size(); ++k) order.push_back(k);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      return is_i ? keys[a] > keys[b] : keys[a] < keys[b];
    });
    std::vector<Scalar> near(most * static_cast<std::size_t>(metric.dimension()));
    for (std::size_t d = 0; d * most < near.size(); ++d) {
      const Scalar* const stream = cells.block(large) + d * keys.size();
      for (std::size_t k = 0; k < most; ++k) near[d * most + k] = stream[order[k]];
    }
    const double others = keys[order[most]];
    const auto count = static_cast<Index>(most);
    known.note(its_pair, near.data(), count, count,
               is_i ? others + cut.tolerance() : others - cut.tolerance());
  }

  const Metric& metric;
  double scale;
  double from;
  SiteNumber large;
  SiteNumber small;
  Random random{7};
  Cells<Scalar> cells;
  SiteState sites;
  Patches<Scalar> patches;
  PairCut<Scalar> cut;
};

/// Moves sites, or has a point come to a cell.
template <class Scalar>
void change(Neighbours<Scalar>& cells) {
  const auto some = [&](SiteNumber s) {
    return static_cast<Index>(cells.random.below(static_cast<std::uint64_t>(cells.cells.size(s))));
  };
  const auto what = cells.random.below(4);
  if (what == 0) cells.move(std::pow(10.0, -1.5 - 5 * cells.random.uniform()));
  if (what == 1) cells.put(cells.large, some(cells.large), 0.58 * cells.random.uniform());
  if (what == 2) cells.put(cells.large, some(cells.large), 0.57 + 0.1 * cells.random.uniform());
  if (what == 3) cells.put(cells.small, some(cells.small), 0);
}

/// How often it holds while sites move and points come and go; whenever it does, no exchange gains.
template <class Scalar>
int how_often(Neighbours<Scalar>& cells, const Domain& domain, int steps) {
  Apart<Scalar> known;
  int held = 0;
  for (int step = 0; step < steps; ++step) {
    change(cells);
    const bool apart = cells.apart(domain);
    if (known.holds(cells.pair())) {
      REQUIRE(apart);
      ++held;
      continue;
    }
    if (!apart) cells.begin();
    cells.note(known, 1 + cells.random.below(40));
  }
  return held;
}

}  // namespace

TEST_SUITE("bands") {
  TEST_CASE_TEMPLATE("a pair that is known to be apart gains by no exchange", Scalar, float,
                     double) {
    for (const int dimension : {1, 2, 3}) {
      for (const bool large_is_i : {true, false}) {
        for (const double origin : {0.0, 1000.0}) {
          CAPTURE(dimension);
          CAPTURE(large_is_i);
          CAPTURE(origin);
          const Metric metric(dimension, Domain());
          Neighbours<Scalar> cells(metric, 1, origin, large_is_i);
          const int steps = dimension == 3 ? 100 : 600;
          CHECK(how_often(cells, Domain(), steps) > steps / 3);
        }
      }
    }
  }

  TEST_CASE_TEMPLATE("and never after sites have gone the shortest way to one", Scalar, float,
                     double) {
    const Metric metric(2, Domain());
    Neighbours<Scalar> cells(metric, 1, 0, true);
    int held = 0;
    for (int trial = 0; trial < 30; ++trial) {
      cells.begin();
      while (!cells.apart(Domain())) cells.begin();
      Apart<Scalar> known;
      cells.note(known, 1 + cells.random.below(200));
      for (int step = 0; step < trial % 5; ++step) {
        change(cells);
        held += known.holds(cells.pair()) ? 1 : 0;
      }
      if (cells.apart(Domain())) cells.move_worst();
      REQUIRE_FALSE(cells.apart(Domain()));
      REQUIRE_FALSE(known.holds(cells.pair()));
    }
    CHECK(held > 10);

    // The points are as far from each other as the bounds say, or nearly.
    for (const std::size_t near : {0U, 1U, 100U}) {
      for (const bool comes : {false, true}) {
        CAPTURE(near);
        CAPTURE(comes);
        cells.begin_worst(comes ? 0 : 50);
        Apart<Scalar> known;
        cells.note(known, near);
        if (comes) cells.put_near(cells.large, 0, 0.4, 0.1);
        CHECK(known.holds(cells.pair()));
        cells.move_worst();
        REQUIRE_FALSE(cells.apart(Domain()));
        CHECK_FALSE(known.holds(cells.pair()));
      }
    }

    // Nor when a point has come while the small cell's site was nearer to it.
    cells.begin_worst(50);
    Apart<Scalar> known;
    cells.note(known, 100);
    cells.place(cells.small, 0.57, 0.3946);
    for (Index k = 0; k < kSmall; ++k) cells.put_near(cells.small, k, 0.6, 0.446);
    cells.measure(cells.small);
    CHECK(known.holds(cells.pair()));
    cells.place(cells.small, 0.55, 0.36);
    CHECK(known.holds(cells.pair()));
    cells.move_worst();
    REQUIRE_FALSE(cells.apart(Domain()));
    CHECK_FALSE(known.holds(cells.pair()));
  }

  // Points with nearly the same keys, far from each other, whose keys the kernels round.
  TEST_CASE_TEMPLATE("what rounding can feign is not taken for apart", Scalar, float, double) {
    const Metric metric(2, Domain());
    for (const double origin : {0.0, 100.0}) {
      CAPTURE(origin);
      Neighbours<Scalar> cells(metric, 1, origin, true);
      cells.begin_far();
      int overlap = 0;
      for (int trial = 0; trial < 300; ++trial) {
        const double tilt = 0.5 * cells.random.uniform();
        cells.place(cells.small, 0.85, 0.5 + tilt);
        const double along = cells.random.uniform() - 0.5;
        cells.put_on_cut(cells.large, 0, 0.4 * along);
        cells.put_on_cut(cells.small, 0, -0.4 * along);
        cells.measure(cells.large);
        cells.measure(cells.small);
        Apart<Scalar> known;
        cells.note(known, 1);
        const bool apart = cells.apart(Domain());
        overlap += apart ? 0 : 1;
        const bool held = known.holds(cells.pair());
        REQUIRE((apart || !held));
      }
      CHECK(overlap > 50);
    }
  }

  TEST_CASE_TEMPLATE("the same on a torus; nothing is known of pairs across its faces", Scalar,
                     float, double) {
    const Domain domain = Domain::periodic(Box::unit(2));
    const Metric metric(2, domain);
    Neighbours<Scalar> inside(metric, 0.4, 0.3, true);
    CHECK(how_often(inside, domain, 400) > 130);
    Neighbours<Scalar> across(metric, 0.4, 1 - 0.4 * 0.61, true);
    CHECK(how_often(across, domain, 100) == 0);
    // As large as half of the torus.
    Neighbours<Scalar> wide(metric, 0.9, 0.05, true);
    Apart<Scalar> known;
    // Nor by one that was inside.
    Neighbours<Scalar> grown(metric, 0.4, 0.3, true);
    grown.note(known, 10);
    CHECK(known.holds(grown.pair()));
    grown.sites.radius[grown.large] = 0.6;
    CHECK_FALSE(known.holds(grown.pair()));
    wide.note(known, 10);
    CHECK_FALSE(known.is_known());
    CHECK_FALSE(known.holds(wide.pair()));
  }

  TEST_CASE("what is known of a pair is forgotten with what is known of its large cell") {
    const Metric metric(2, Domain());
    Neighbours<float> cells(metric, 1, 0, true);
    Apart<float> known;
    CHECK_FALSE(known.holds(cells.pair()));
    cells.note(known, 10);
    CHECK(known.holds(cells.pair()));
    for (Index k = 0; k < 300; ++k) cells.put(cells.large, k, 0);  // more than are kept in mind
    CHECK_FALSE(known.holds(cells.pair()));
    cells.note(known, 10);
    CHECK(known.holds(cells.pair()));
    cells.patches.forget();
    CHECK_FALSE(known.holds(cells.pair()));
  }
}
