// The swap of one pair of cells, against sorting and counting.
#include "relax/swap.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "random.h"
#include "relax/update.h"
#include "support/generate.h"
#include "support/oracle.h"

using ccvt::Box;
using ccvt::Candidate;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Exchange;
using ccvt::Index;
using ccvt::Metric;
using ccvt::Options;
using ccvt::PairSwapper;
using ccvt::Patches;
using ccvt::PointNumber;
using ccvt::PointOfAll;
using ccvt::PointPruning;
using ccvt::Random;
using ccvt::SiteNumber;
using ccvt::SiteState;
using ccvt::SwapMethod;
using namespace ccvt::test;

namespace {

constexpr SiteNumber site_i(0);
constexpr SiteNumber site_j(1);

constexpr SwapMethod methods[] = {SwapMethod::median, SwapMethod::heap, SwapMethod::sort};

// Whole numbers below `values`: few of them make ties, and sums are exact.
std::vector<Candidate> candidates(Random& random, std::size_t count, std::uint64_t values) {
  std::vector<Candidate> list;
  for (std::size_t k = 0; k < count; ++k) {
    list.push_back({static_cast<double>(random.below(values)), static_cast<Index>(3 * k)});
  }
  return list;
}

// The largest gain of exchanging equally many of both, if each exchange must gain more than
// `margin`.
double best_gain(const Exchange& all, double margin) {
  std::vector<double> down;
  std::vector<double> up;
  for (const Candidate& c : all.from_i) down.push_back(c.key);
  for (const Candidate& c : all.from_j) up.push_back(c.key);
  std::sort(down.rbegin(), down.rend());
  std::sort(up.begin(), up.end());
  double gain = 0;
  for (std::size_t k = 0; k < std::min(down.size(), up.size()); ++k) {
    if (down[k] - up[k] > margin) gain += down[k] - up[k];
  }
  return gain;
}

bool drawn_from(const std::vector<Candidate>& chosen, const std::vector<Candidate>& all) {
  std::set<Index> places;
  for (const Candidate& c : chosen) {
    places.insert(c.place);
    const bool known = std::any_of(all.begin(), all.end(), [&](const Candidate& a) {
      return a.place == c.place && a.key == c.key;
    });
    if (!known) return false;
  }
  return places.size() == chosen.size();
}

double gain_of(const Exchange& moves) {
  double gain = 0;
  for (const Candidate& c : moves.from_i) gain += c.key;
  for (const Candidate& c : moves.from_j) gain -= c.key;
  return gain;
}

/// Two cells and their sites, and what they hold.
template <class Scalar>
struct PairOfCells {
  PairOfCells(const Metric& metric, const ccvt::Points<Scalar>& all_points, Index size_i)
      : points(all_points), cells(metric.dimension(), sizes(size_i)), sites(metric.dimension(), 2) {
    for (Index p = 0; p < points.cols(); ++p) {
      const SiteNumber s = p < size_i ? site_i : site_j;
      cells.put(s, p < size_i ? p : p - size_i, PointOfAll(p), points.col(p).data());
      for (int d = 0; d < metric.dimension(); ++d) {
        sites.at(s)[d] = static_cast<double>(points(d, p));
      }
    }
    ccvt::update_site(metric, cells, sites, site_i);
    ccvt::update_site(metric, cells, sites, site_j);
  }
  [[nodiscard]] std::vector<Index> sizes(Index size_i) const {
    return {size_i, static_cast<Index>(points.cols()) - size_i};
  }

  const ccvt::Points<Scalar>& points;
  Cells<Scalar> cells;
  SiteState sites;
};

// Of |p - s_i|^2 - |p - s_j|^2 over all points of both cells, cell i must hold the smallest.
template <class Scalar>
std::string pair_faults(const Domain& domain, const PairOfCells<Scalar>& pair) {
  const auto dimension = static_cast<int>(pair.sites.dimension);
  std::string wrong;
  std::vector<Real> keys;
  Real held = 0;
  Real scale = 0;
  std::set<PointNumber> seen;
  for (const SiteNumber s : {site_i, site_j}) {
    std::vector<Scalar> x(static_cast<std::size_t>(dimension));
    for (Index k = 0; k < pair.cells.size(s); ++k) {
      pair.cells.get(s, k, x.data());
      const PointNumber p(pair.cells.point(s, k).index());
      seen.insert(p);
      if (!std::equal(x.begin(), x.end(), pair.points.col(p.index()).data()))
        wrong += "coordinates ";
      const Real to_i = squared_distance(domain, dimension, x.data(), pair.sites.at(site_i));
      const Real to_j = squared_distance(domain, dimension, x.data(), pair.sites.at(site_j));
      keys.push_back(to_i - to_j);
      scale = std::max({scale, to_i, to_j});
      if (s == site_i) held += keys.back();
      const Real distance = std::sqrt(s == site_i ? to_i : to_j);
      if (distance > pair.sites.radius[s]) wrong += "radius ";
    }
  }
  if (seen.size() != static_cast<std::size_t>(pair.points.cols())) wrong += "points ";
  std::sort(keys.begin(), keys.end());
  Real least = 0;
  for (Index k = 0; k < pair.cells.size(site_i); ++k) least += keys[static_cast<std::size_t>(k)];
  // Keys are decided in double: 2^-52 of the squares they are differences of, each.
  if (held - least > 64 * (dimension + 4) * 0x1p-52L * scale * keys.size()) wrong += "not least ";
  return wrong;
}

}  // namespace

TEST_SUITE_BEGIN("swap");

TEST_CASE("each method finds an exchange of the greatest gain") {
  Random random(4);
  for (int trial = 0; trial < 3000; ++trial) {
    const std::uint64_t values = trial % 3 == 0 ? 3 : trial % 3 == 1 ? 20 : 1'000'000;
    Exchange all;
    all.from_i = candidates(random, random.below(40), values);
    all.from_j = candidates(random, random.below(40), values);
    for (const double margin : {0.0, 1.0, 2.5}) {
      for (const SwapMethod method : methods) {
        CAPTURE(static_cast<int>(method));
        CAPTURE(margin);
        Exchange moves = all;
        ccvt::select_exchange(method, margin, moves);
        REQUIRE(moves.from_i.size() == moves.from_j.size());
        REQUIRE(drawn_from(moves.from_i, all.from_i));
        REQUIRE(drawn_from(moves.from_j, all.from_j));
        REQUIRE(gain_of(moves) == best_gain(all, margin));
        // However they are paired up: the weakest of both sides gains.
        for (const Candidate& a : moves.from_i) {
          for (const Candidate& b : moves.from_j) REQUIRE(a.key - b.key > margin);
        }
      }
    }
  }
}

TEST_CASE("ties and gains within the margin are no exchange") {
  Random random(5);
  for (const SwapMethod method : methods) {
    for (const std::size_t count : {1U, 2U, 7U, 100U}) {
      Exchange ties;
      ties.from_i = candidates(random, count, 1);
      ties.from_j = candidates(random, count, 1);
      ccvt::select_exchange(method, 0, ties);
      CHECK(ties.from_i.empty());
      CHECK(ties.from_j.empty());
      Exchange close;
      close.from_i = candidates(random, count, 2);
      close.from_j = candidates(random, count, 2);
      ccvt::select_exchange(method, 1, close);
      CHECK(close.from_i.empty());
      CHECK(close.from_j.empty());
    }
    Exchange nobody;
    ccvt::select_exchange(method, 0, nobody);
    CHECK(nobody.from_i.empty());
    Exchange one_sided;
    one_sided.from_i = candidates(random, 5, 9);
    ccvt::select_exchange(method, 0, one_sided);
    CHECK(one_sided.from_i.empty());
  }
}

TEST_CASE_TEMPLATE("a swap leaves the pair optimal and its radii bounds", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 5, 17}) {
    for (const bool periodic : {false, true}) {
      if (periodic && dimension > 5) continue;
      const Box box = uneven_box(dimension);
      const Domain domain = periodic ? Domain::periodic(box) : Domain();
      const Metric metric(dimension, domain);
      for (const Layout layout : all_layouts) {
        for (const Index size_i : {1, 40, 150, 299}) {
          const auto points = make_points<Scalar>(layout, box, 300);
          for (const SwapMethod method : methods) {
            for (const auto pruning :
                 {PointPruning::none, PointPruning::distance, PointPruning::extremes}) {
              for (const bool median_cut : {false, true}) {
                CAPTURE(dimension);
                CAPTURE(periodic);
                CAPTURE(name_of(layout));
                CAPTURE(size_i);
                CAPTURE(static_cast<int>(method));
                CAPTURE(static_cast<int>(pruning));
                PairOfCells<Scalar> pair(metric, points, size_i);
                Options options;
                options.swap = method;
                options.point_pruning = pruning;
                options.median_cut_pruning = median_cut;
                PairSwapper<Scalar> swap(metric, options, 6.0);
                Patches<Scalar> patches(dimension, pair.cells.sizes());
                swap(pair.cells, patches, pair.sites, site_i, site_j);
                REQUIRE(pair_faults(domain, pair) == "");
                // What is optimal stays, from the other side too.
                REQUIRE(swap(pair.cells, patches, pair.sites, site_i, site_j) == 0);
                REQUIRE(swap(pair.cells, patches, pair.sites, site_j, site_i) == 0);
              }
            }
          }
        }
      }
    }
  }
}

/// The points of a cell, whatever their order.
template <class Scalar>
std::vector<PointOfAll> sorted_points(const Cells<Scalar>& cells, SiteNumber site) {
  std::vector<PointOfAll> points(cells.points(site).begin(), cells.points(site).end());
  std::sort(points.begin(), points.end());
  return points;
}

/// Patches of which these cells have been looked at often.
template <class Scalar>
void wear(Patches<Scalar>& patches, Cells<Scalar>& cells) {
  typename Patches<Scalar>::Scratch scratch;
  for (int k = 0; k < 100; ++k) {
    for (const SiteNumber s : cells.sites()) patches.look(cells, s, scratch);
  }
}

template <class Scalar>
std::string box_faults(const Cells<Scalar>& cells, const Patches<Scalar>& patches, SiteNumber s) {
  const std::size_t boxes = patches.count(s) + 1;
  std::vector<Scalar> x(cells.dimension());
  for (Index k = 0; k < cells.size(s); ++k) {
    cells.get(s, k, x.data());
    for (std::size_t d = 0; d < x.size(); ++d) {
      const auto own = static_cast<std::size_t>(k / patches.size(s));
      for (const std::size_t box : {own, boxes - 1}) {
        if (x[d] < patches.low(s)[d * boxes + box]) return "a point below its box";
        if (x[d] > patches.high(s)[d * boxes + box]) return "a point above its box";
      }
    }
  }
  return "";
}

TEST_CASE_TEMPLATE("cells in patches: the same points move, and no others", Scalar, float, double) {
  struct Case {
    int dimension;
    Index size_i;
    Index points;
  };
  // Both cells divided, one, and in a dimension in which hardly any is.
  for (const Case& c : {Case{1, 500, 1100}, Case{2, 4000, 9000}, Case{2, 300, 9000},
                        Case{2, 8800, 9000}, Case{3, 29000, 29200}}) {
    for (const bool periodic : {false, true}) {
      for (const Layout layout : all_layouts) {
        CAPTURE(c.dimension);
        CAPTURE(c.size_i);
        CAPTURE(periodic);
        CAPTURE(name_of(layout));
        const Box box = uneven_box(c.dimension);
        const Domain domain = periodic ? Domain::periodic(box) : Domain();
        const Metric metric(c.dimension, domain);
        const auto points = make_points<Scalar>(layout, box, c.points);
        PairOfCells<Scalar> whole(metric, points, c.size_i);
        PairOfCells<Scalar> divided(metric, points, c.size_i);
        Patches<Scalar> none(c.dimension, whole.cells.sizes());
        Patches<Scalar> patches(c.dimension, whole.cells.sizes());
        PairSwapper<Scalar> swap(metric, Options{}, 6.0);
        // Which of several points with one key moves hangs on their order.
        const bool ties = layout != Layout::random && layout != Layout::clusters;
        for (int round = 0; round < 6; ++round) {
          wear(patches, divided.cells);
          const Index moved = swap(whole.cells, none, whole.sites, site_i, site_j);
          const Index also_moved = swap(divided.cells, patches, divided.sites, site_i, site_j);
          REQUIRE(pair_faults(domain, divided) == "");
          for (const SiteNumber s : whole.cells.sites()) {
            if (patches.has(s)) REQUIRE(box_faults(divided.cells, patches, s) == "");
            ccvt::update_site(metric, whole.cells, whole.sites, s);
            ccvt::update_site(metric, divided.cells, divided.sites, s);
          }
          if (ties) continue;
          REQUIRE(also_moved == moved);
          REQUIRE(sorted_points(divided.cells, site_i) == sorted_points(whole.cells, site_i));
          divided.sites = whole.sites;  // and not as rounding has it, in another order
        }
        CHECK((patches.has(site_i) || patches.has(site_j)));
        CHECK_FALSE((none.has(site_i) || none.has(site_j)));
      }
    }
  }
}

TEST_CASE_TEMPLATE("cells in patches that have next to no width: bins in it are not divided",
                   Scalar, float, double) {
  const Metric metric(2, Domain());
  auto points = make_points<Scalar>(Layout::random, Box::unit(2), 9000);
  for (Index p = 0; p < 9000; ++p) {
    points(0, p) = p % 2 == 0 ? 0 : std::numeric_limits<Scalar>::denorm_min();
  }
  PairOfCells<Scalar> pair(metric, points, 4000);
  Patches<Scalar> patches(2, pair.cells.sizes());
  wear(patches, pair.cells);
  for (const SiteNumber s : pair.cells.sites()) {
    CHECK(patches.has(s));
    CHECK(box_faults(pair.cells, patches, s) == "");
  }
}

// The kernels' cut is rounded as coordinates are, and bounds must be on that one.
TEST_CASE("cells in patches far from the origin: their coordinates are coarse") {
  for (const double offset : {1e3, 1e4, 1e5}) {
    Box box = Box::unit(2);
    box.lower.eigen().array() += offset;
    box.upper.eigen().array() += offset;
    const Metric metric(2, Domain());
    for (Index size_i = 4000; size_i < 5000; size_i += 100) {
      CAPTURE(offset);
      CAPTURE(size_i);
      const auto points = make_points<float>(Layout::random, box, 9000);
      PairOfCells<float> whole(metric, points, size_i);
      PairOfCells<float> divided(metric, points, size_i);
      Patches<float> none(2, whole.cells.sizes());
      Patches<float> patches(2, whole.cells.sizes());
      PairSwapper<float> swap(metric, Options{}, offset + 1);
      for (int round = 0; round < 20; ++round) {
        wear(patches, divided.cells);
        const Index moved = swap(whole.cells, none, whole.sites, site_i, site_j);
        REQUIRE(swap(divided.cells, patches, divided.sites, site_i, site_j) == moved);
        REQUIRE(pair_faults(Domain(), divided) == "");
        for (const SiteNumber s : whole.cells.sites()) {
          ccvt::update_site(metric, whole.cells, whole.sites, s);
          ccvt::update_site(metric, divided.cells, divided.sites, s);
        }
      }
      CHECK(patches.has(site_i));
    }
  }
}

TEST_CASE("patches lie close together, and are divided anew when they do not") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 20000);
  PairOfCells<float> pair(Metric(2, Domain()), points, 10000);
  Patches<float> patches(2, pair.cells.sizes());
  const auto area = [&] {
    double sum = 0;
    const std::size_t boxes = patches.count(site_i) + 1;
    for (std::size_t k = 0; k + 1 < boxes; ++k) {
      sum += static_cast<double>(patches.high(site_i)[k] - patches.low(site_i)[k]) *
             static_cast<double>(patches.high(site_i)[boxes + k] - patches.low(site_i)[boxes + k]);
    }
    return sum;
  };
  wear(patches, pair.cells);
  REQUIRE(patches.has(site_i));
  CHECK(patches.count(site_i) > 20);
  CHECK(area() < 1.5);  // of the whole; in no order, they would cover it each
  const std::vector<float> far{0.5F, 0.5F};
  for (Index k = 0; k < 2500; ++k) patches.replace(site_i, k, far.data(), far.data());
  CHECK(area() > 2);
  wear(patches, pair.cells);
  CHECK(area() > 2);
  patches.replace(site_i, 0, far.data(), far.data());  // a quarter, and one more
  wear(patches, pair.cells);
  CHECK(area() < 1.5);
}

TEST_CASE("spheres meet when their radii reach, across the border of a torus too") {
  const Domain torus = Domain::periodic(Box::unit(2));
  SiteState sites(2, 2);
  sites.at(site_i)[0] = 0.125;
  sites.at(site_j)[0] = 0.875;
  sites.radius = {0.25, 0.25};
  CHECK(PairSwapper<float>::spheres_meet(Metric(2, torus), sites, site_i, site_j));
  CHECK_FALSE(PairSwapper<float>::spheres_meet(Metric(2, Domain()), sites, site_i, site_j));
  sites.radius = {0.125, 0.125};  // they touch
  CHECK(PairSwapper<float>::spheres_meet(Metric(2, torus), sites, site_i, site_j));
  sites.radius = {0.125, 0.12};
  CHECK_FALSE(PairSwapper<float>::spheres_meet(Metric(2, torus), sites, site_i, site_j));
}

TEST_CASE("a cell that ends at a face of the torus, far from the origin") {
  for (const double offset : {0.0, 1e7, 3e7, 1e8, 1e12}) {
    CAPTURE(offset);
    Box box = Box::unit(1);
    box.lower.eigen().array() += offset;
    box.upper.eigen().array() += offset;
    const Domain domain = Domain::periodic(box);
    const Metric metric(1, domain);
    ccvt::Points<double> points(1, 6);
    points << 0, 0.75, 0.875, 0.5, 0.625, 0.75;
    points.array() += offset;
    PairOfCells<double> pair(metric, points, 3);
    PairSwapper<double> swap(metric, Options{}, offset + 1);
    Patches<double> patches(1, pair.cells.sizes());
    CHECK(swap(pair.cells, patches, pair.sites, site_i, site_j) == 0);
    CHECK(pair_faults(domain, pair) == "");
  }
}

TEST_SUITE_END();
