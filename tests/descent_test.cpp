// Levels lowered by quasi-Newton steps on power diagrams: counting, directions, and what comes out.
#include "descent/descent.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/metrics.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "kernels/power.h"
#include "random.h"
#include "relax/potential.h"
#include "support/generate.h"
#include "support/oracle.h"
#include "support/problems.h"
#include "support/same.h"

using ccvt::Arena;
using ccvt::Borders;
using ccvt::Box;
using ccvt::Cells;
using ccvt::Domain;
using ccvt::Index;
using ccvt::Lbfgs;
using ccvt::Metric;
using ccvt::Options;
using ccvt::Pair;
using ccvt::PointOfAll;
using ccvt::PowerDiagram;
using ccvt::Problem;
using ccvt::Random;
using ccvt::SiteNumber;
using ccvt::Termination;
using namespace ccvt::test;

namespace {

template <class Scalar>
std::vector<Scalar> random_values(Random& random, std::size_t count) {
  std::vector<Scalar> values(count);
  for (Scalar& value : values) value = static_cast<Scalar>(random.uniform() - 0.5);
  return values;
}

template <class Scalar>
void check_kernels(int dimension, Index sites, Index count, Index stride) {
  Random random(1, 1);
  const auto size = static_cast<std::size_t>(dimension);
  const auto points = random_values<Scalar>(random, size * static_cast<std::size_t>(stride));
  const auto slopes = random_values<Scalar>(random, size * static_cast<std::size_t>(sites));
  auto offsets = random_values<Scalar>(random, static_cast<std::size_t>(sites));
  for (Scalar& offset : offsets) offset /= 4;
  const ccvt::kernels::PowerSites<Scalar> seen{slopes.data(), offsets.data(), sites};
  std::vector<Index> nearest(static_cast<std::size_t>(count));
  std::vector<Index> next(nearest.size());
  std::vector<Scalar> margin(nearest.size());
  ccvt::kernels::nearest_powers<Scalar>(points.data(), stride, count, dimension, seen,
                                        {nearest.data(), next.data(), margin.data()});
  const auto width = static_cast<Scalar>(0.125);
  std::vector<Index> places(nearest.size());
  places.resize(static_cast<std::size_t>(ccvt::kernels::contested_places(
      points.data(), stride, count, dimension, seen, width, places.data())));

  std::vector<Index> expected_places;
  for (Index k = 0; k < count; ++k) {
    std::vector<Scalar> power(offsets);
    for (std::size_t c = 0; c < power.size(); ++c) {
      for (std::size_t d = 0; d < size; ++d) {
        power[c] -= points[d * static_cast<std::size_t>(stride) + static_cast<std::size_t>(k)] *
                    slopes[c * size + d];
      }
    }
    const auto best = std::min_element(power.begin(), power.end());
    const auto at = static_cast<std::size_t>(k);
    REQUIRE(nearest[at] == best - power.begin());
    const Scalar least = *best;
    if (std::any_of(power.begin() + 1, power.end(),
                    [&](Scalar p) { return p < power[0] + width; })) {
      expected_places.push_back(k);
    }
    *best = std::numeric_limits<Scalar>::infinity();
    const auto second = std::min_element(power.begin(), power.end());
    REQUIRE(margin[at] == *second - least);
    if (sites > 1) REQUIRE(next[at] == second - power.begin());
  }
  CHECK(places == expected_places);
}

/// Points in cells around sites, by power distance and so with any sizes, and all pairs of sites.
template <class Scalar>
struct Diagram {
  Diagram(int dimension, bool periodic, Index site_count, Index point_count)
      : domain(periodic ? Domain::periodic(Box::unit(dimension)) : Domain()),
        metric(dimension, domain),
        points(make_points<Scalar>(Layout::random, Box::unit(dimension), point_count)),
        weight(static_cast<std::size_t>(site_count)) {
    Random random(7, 7);
    for (Index s = 0; s < site_count; ++s) {
      for (int d = 0; d < dimension; ++d) position.push_back(random.uniform());
    }
    for (double& w : weight) w = 0.1 * std::pow(site_count, -2.0 / dimension) * random.uniform();
    for (const SiteNumber a : ccvt::sites_below(site_count)) {
      for (const SiteNumber b : ccvt::sites_below(site_count).after(a)) near.emplace_back(a, b);
    }
    const std::vector<Index> owner = owners({std::vector<double>(position.size(), 0.0), weight});
    std::vector<Index> sizes(weight.size());
    for (const Index o : owner) ++sizes[static_cast<std::size_t>(o)];
    cells = Cells<Scalar>(dimension, sizes);
    std::vector<Index> next(weight.size());
    radius.resize(weight.size());
    for (Index p = 0; p < point_count; ++p) {
      const auto s = static_cast<std::size_t>(owner[static_cast<std::size_t>(p)]);
      cells.put(SiteNumber(s), next[s]++, PointOfAll(p), points.col(p).data());
      radius[s] =
          std::max(radius[s],
                   std::sqrt(metric.squared_distance(points.col(p).data(), &position[s * size()])));
    }
  }
  [[nodiscard]] std::size_t size() const { return metric.coordinate_count(); }
  [[nodiscard]] double power(Index p, std::size_t s, const PowerDiagram& diagram) const {
    double sum = -diagram.weight[s];
    for (std::size_t d = 0; d < size(); ++d) {
      const double to = position[s * size() + d] + diagram.step[s * size() + d];
      const double u = metric.wrap(
          static_cast<double>(points(static_cast<Index>(d), p)) - metric.into_box(to, d), d);
      sum += u * u;
    }
    return sum;
  }
  [[nodiscard]] std::vector<Index> owners(const PowerDiagram& diagram) const {
    std::vector<Index> result;
    for (Index p = 0; p < points.cols(); ++p) {
      std::size_t best = 0;
      for (std::size_t s = 1; s < weight.size(); ++s) {
        if (power(p, s, diagram) < power(p, best, diagram)) best = s;
      }
      result.push_back(static_cast<Index>(best));
    }
    return result;
  }

  Domain domain;
  Metric metric;
  ccvt::Points<Scalar> points;
  std::vector<double> position;
  std::vector<double> weight;
  std::vector<double> radius;
  std::vector<Pair> near;
  Cells<Scalar> cells;
};

/// Of a diagram a little off, all that is counted, against the definition.
template <class Scalar>
void check_counts(int dimension, bool periodic, double share, double off) {
  const Diagram<Scalar> given(dimension, periodic, 40, 9001);
  const Arena arena(2);
  const ccvt::Tiling tiling(given.weight.size(), 16);
  Borders<Scalar> borders(given.metric, arena, tiling);
  borders.find(given.cells, given.position, given.radius, given.weight, given.near, share);
  Random random(3, 3);
  PowerDiagram diagram{std::vector<double>(given.position.size()), given.weight};
  for (double& u : diagram.step) u = off * (random.uniform() - 0.5);
  for (double& w : diagram.weight) w += off * 0.01 * (random.uniform() - 0.5);
  borders.count(diagram);
  REQUIRE(borders.used() < 1);

  const std::vector<Index> owner = given.owners(diagram);
  const std::size_t size = given.size();
  std::vector<double> count(given.weight.size());
  std::vector<double> sum(given.position.size());
  double energy = 0;
  for (Index p = 0; p < given.points.cols(); ++p) {
    const auto s = static_cast<std::size_t>(owner[static_cast<std::size_t>(p)]);
    ++count[s];
    energy += given.power(p, s, diagram);
    for (std::size_t d = 0; d < size; ++d) {
      const double at =
          given.metric.into_box(given.position[s * size + d] + diagram.step[s * size + d], d);
      sum[s * size + d] +=
          given.metric.wrap(static_cast<double>(given.points(static_cast<Index>(d), p)) - at, d);
    }
  }
  // Rounding may put a point on either side of a border.
  double differing = 0;
  for (std::size_t s = 0; s < count.size(); ++s) {
    const double capacity = given.cells.size(SiteNumber(s));
    energy += diagram.weight[s] * capacity;
    const double difference = borders.surplus()[s] + capacity - count[s];
    differing += std::abs(difference);
    if (difference != 0 || count[s] == 0) continue;
    for (std::size_t d = 0; d < size; ++d) {
      CHECK(borders.to_centroid()[s * size + d] ==
            doctest::Approx(sum[s * size + d] / count[s]).epsilon(1e-3).scale(1));
    }
  }
  CHECK(differing <= 2);
  CHECK(borders.energy() == doctest::Approx(energy).epsilon(1e-6));
}

template <class Scalar>
void check_descended(const Problem<Scalar>& problem, Options options) {
  options.level_points = 4;
  const auto result = ccvt::tessellate(problem, options);
  CHECK(result.summary.termination == Termination::stable);
  CHECK(faults(problem, result) == "");
  if (problem.domain().is_periodic()) return;  // cells may be too large for it
  CHECK(std::any_of(result.summary.phases.begin(), result.summary.phases.end(),
                    [](const auto& phase) { return phase.name == "descent" && phase.tasks > 0; }));
}

}  // namespace

TEST_SUITE_BEGIN("descent");

TEST_CASE_TEMPLATE("kernels: nearest by power, and contested places", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 4, 7}) {
    for (const Index sites : {1, 2, 9, 31}) {
      for (const Index count : {0, 1, 7, 16, 100}) {
        CAPTURE(dimension);
        CAPTURE(sites);
        CAPTURE(count);
        check_kernels<Scalar>(dimension, sites, count, count + 3);
      }
    }
  }
}

TEST_CASE("the potential on a weighted graph solves its Laplacian") {
  Random random(5, 5);
  constexpr std::size_t kSites = 3000;
  std::vector<std::vector<std::pair<SiteNumber, float>>> edges(kSites);
  for (std::size_t s = 1; s < kSites; ++s) {
    for (const std::size_t t : {s - 1, random.below(s)}) {
      const auto weight = static_cast<float>(0.1 + 10 * random.uniform());
      edges[s].emplace_back(t, weight);
      edges[t].emplace_back(s, weight);
    }
  }
  ccvt::WeightedGraph graph;
  graph.first.push_back(0);
  for (const auto& row : edges) {
    for (const auto& [t, weight] : row) {
      graph.neighbour.push_back(t);
      graph.weight.push_back(weight);
    }
    graph.first.push_back(graph.neighbour.size());
  }
  std::vector<double> e(kSites);
  for (double& value : e) value = std::floor(1000 * random.uniform());
  e[0] -= std::accumulate(e.begin(), e.end(), 0.0);
  const std::vector<double> phi = ccvt::potential(graph, e);
  const double most = std::abs(e[0]);
  for (std::size_t s = 0; s < kSites; ++s) {
    double out = 0;
    for (const auto& [t, weight] : edges[s]) out += double{weight} * (phi[s] - phi[t]);
    REQUIRE(std::abs(out - e[s]) <= 0.0101 * most);
  }
}

TEST_CASE("directions: the minimum of a quadratic function in a few steps") {
  constexpr std::size_t kSites = 40;
  const Arena arena(1);
  std::vector<double> weights(kSites);
  std::vector<double> curvature(2 * kSites);
  std::vector<double> x(2 * kSites);
  Random random(2, 2);
  for (double& w : weights) w = 0.5 + random.uniform();
  for (double& c : curvature) c = 0.2 + 3 * random.uniform();
  for (double& v : x) v = random.uniform() - 0.5;
  Lbfgs lbfgs(weights, 2, arena);
  const auto gradient = [&] {
    std::vector<double> g(x.size());
    for (std::size_t k = 0; k < x.size(); ++k) g[k] = curvature[k] * x[k];
    return g;
  };
  const double before = lbfgs.dot(gradient(), gradient());
  for (int step = 0; step < 25; ++step) {
    const std::vector<double> old = gradient();
    const std::vector<double> direction = lbfgs.direction(old);
    CHECK(lbfgs.dot(direction, old) < 0);
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += direction[k] * (step == 0 ? 0.3 : 1);
    std::vector<double> change = gradient();
    for (std::size_t k = 0; k < x.size(); ++k) change[k] -= old[k];
    lbfgs.add(direction, change);
  }
  CHECK(lbfgs.dot(gradient(), gradient()) < 1e-12 * before);
}

TEST_CASE_TEMPLATE("borders: counts are those of all points", Scalar, float, double) {
  for (const int dimension : {1, 2, 3}) {
    for (const bool periodic : {false, true}) {
      CAPTURE(dimension);
      CAPTURE(periodic);
      check_counts<Scalar>(dimension, periodic, 0.3, 0);
      check_counts<Scalar>(dimension, periodic, 0.3, 1e-3);
      check_counts<Scalar>(dimension, periodic, 10, 1e-2);
    }
  }
}

TEST_CASE_TEMPLATE("a tessellation descended to is what it claims", Scalar, float, double) {
  for_problems<Scalar>(
      {1, 2, 3, 5}, 60 * 40 + 7, 60, [](const Problem<Scalar>& problem, const auto&, Layout) {
        check_descended(problem, {.seed = 2, .descent_points = 4});
        check_descended(problem, {.seed = 2, .descent_points = 20});  // a step before pairs
      });
}

TEST_CASE("a descent of points that are scaled by a power of two is the same, at any scale") {
  const auto points = make_points<double>(Layout::clusters, Box::unit(2), 16 * 2000);
  const Options options{.descent_points = 256};
  const auto plain = tessellate(Problem<double>(points, 16), options);
  for (const double scale : {0x1p-300, 0x1p-60, 0x1p90, 0x1p400}) {
    CAPTURE(scale);
    const ccvt::Points<double> scaled_points = points * scale;
    const auto scaled = tessellate(Problem<double>(scaled_points, 16), options);
    CHECK(scaled.owners == plain.owners);
    CHECK(scaled.sites == ccvt::Points<double>(plain.sites * scale));
    CHECK(scaled.summary.iterations == plain.summary.iterations);
  }
}

TEST_CASE("tiles that do not fit the ranges of sites, and a cell of one point") {
  // Of 3000 points a site, 21 sites are a tile.
  std::vector<Index> capacities(200, 3000);
  capacities[77] = 1;
  const auto points = make_points<float>(Layout::random, Box::unit(2), sum_of(capacities));
  Problem<float> problem(points, 200);
  problem.set_capacities(capacities);
  const auto one = ccvt::tessellate(problem, {.threads = 1});
  CHECK(one.summary.termination == Termination::stable);
  CHECK(one.summary.iterations < 400);
  for (const int threads : {2, 3, 8}) {
    CHECK(differences(one, ccvt::tessellate(problem, {.threads = threads})) == "");
  }
}

// Cells that are divided into patches, and left to the pairs.
TEST_CASE("pairs alone, of large cells") {
  for (const Layout layout : {Layout::random, Layout::clusters, Layout::duplicates}) {
    for (const bool periodic : {false, true}) {
      CAPTURE(name_of(layout));
      CAPTURE(periodic);
      const Box box = uneven_box(2);
      const auto points = make_points<float>(layout, box, 12 * 4500);
      Problem<float> problem(points, 12);
      if (periodic) problem.set_domain(Domain::periodic(box));
      const auto one = ccvt::tessellate(problem, {.threads = 1, .descent_points = 0});
      CHECK(one.summary.termination == Termination::stable);
      CHECK(faults(problem, one) == "");
      for (const int threads : {2, 3}) {
        const Options options{.threads = threads, .descent_points = 0};
        CHECK(differences(one, ccvt::tessellate(problem, options)) == "");
      }
    }
  }
}

// Pairs of such cells creep: they must be left what is nearly at rest.
TEST_CASE("many points a site: a descent leaves little to the pairs") {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    CAPTURE(seed);
    const auto points =
        ccvt::sample_uniform<float, 2>(Box::unit(2), 16 * 65536, seed, ccvt::Distribution::white);
    const auto summary = ccvt::tessellate(points, 16, {.seed = seed}).summary;
    CHECK(summary.termination == Termination::stable);
    CHECK(summary.iterations < 80);
  }
}

TEST_CASE_TEMPLATE("until blue noise: the end is what it claims", Scalar, float, double) {
  for (const int dimension : {1, 2, 3, 5}) {
    for (const Layout layout : all_layouts) {
      CAPTURE(dimension);
      CAPTURE(name_of(layout));
      const Box box = uneven_box(dimension);
      const auto points = make_points<Scalar>(layout, box, 60 * 40 + 7);
      const Problem<Scalar> problem(points, 60);
      Options options{.until = ccvt::Until::blue_noise, .level_points = 4, .descent_points = 20};
      const auto result = ccvt::tessellate(problem, options);
      CHECK(result.summary.termination == Termination::blue_noise);
      CHECK(faults(problem, result) == "");
      options.threads = 3;
      CHECK(differences(result, ccvt::tessellate(problem, options)) == "");
    }
  }
}

TEST_CASE("until blue noise: with few points a site, and from given owners, as stable") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 300 * 500);
  Problem<float> problem(points, 300);
  const auto stable = ccvt::tessellate(problem);
  Options options = Options::samples();
  CHECK(differences(stable, ccvt::tessellate(problem, options)) == "");
  options.descent_points = 10;
  const auto even = ccvt::tessellate(problem, options);
  CHECK(even.summary.termination == Termination::blue_noise);
  CHECK(even.summary.energy > stable.summary.energy);
  problem.set_initial_owners(even.owners);
  CHECK(ccvt::tessellate(problem, options).summary.termination == Termination::stable);
}

TEST_CASE("until blue noise: sites stay irregular; stable ones become a lattice") {
  constexpr Index kSites = 256;
  const auto torus = ccvt::Domain::periodic(Box::unit(2));
  const auto psi6 = [&](Index points_per_site, ccvt::Until until) {
    std::vector<ccvt::PointSet> sets;
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      const auto points = ccvt::sample_uniform<float, 2>(Box::unit(2), kSites * points_per_site,
                                                         seed, ccvt::Distribution::white);
      Problem<float> problem(points, kSites);
      problem.set_domain(torus);
      sets.emplace_back(ccvt::tessellate(problem, {.seed = seed, .until = until}).sites, torus);
    }
    return ccvt::analyze(sets).order.psi6_local;
  };
  const double few = psi6(256, ccvt::Until::stable);
  CHECK(psi6(4096, ccvt::Until::blue_noise) < few + 0.12);
  CHECK(psi6(4096, ccvt::Until::stable) > few + 0.2);
}

TEST_CASE("a run that is cancelled anywhere in a descent leaves capacities exact") {
  const auto points = make_points<float>(Layout::random, Box::unit(2), 3000);
  const Problem<float> problem(points, 20);
  for (const auto until : {ccvt::Until::stable, ccvt::Until::blue_noise}) {
    for (const int stop : {1, 5, 8, 10, 12, 14, 16, 19, 23, 28, 34}) {
      CAPTURE(stop);
      int asked = 0;
      Options options{.threads = 1, .until = until, .level_points = 8, .descent_points = 8};
      options.cancelled = [&] {
        // So slowly that each check is due again.
        std::this_thread::sleep_for(std::chrono::milliseconds(21));
        return ++asked >= stop;
      };
      const auto result = ccvt::tessellate(problem, options);
      CHECK(ccvt::capacity_error(result.owners, 20) == 0);
      if (asked >= stop) CHECK(result.summary.termination == Termination::cancelled);
    }
  }
}

TEST_CASE("capacities far apart, and the same bits for any number of threads") {
  const Box box = Box::unit(2);
  std::vector<Index> capacities;
  for (Index s = 0; s < 50; ++s) capacities.push_back(20 + 5 * s * s / 10);
  const auto points = make_points<float>(Layout::clusters, box, sum_of(capacities));
  Problem<float> problem(points, 50);
  problem.set_capacities(capacities);
  Options options{.threads = 1, .seed = 5, .descent_points = 4};
  check_descended(problem, options);
  const auto one = ccvt::tessellate(problem, options);
  for (const int threads : {2, 3, 8}) {
    CAPTURE(threads);
    options.threads = threads;
    CHECK(differences(one, ccvt::tessellate(problem, options)) == "");
  }
}

TEST_SUITE_END();
