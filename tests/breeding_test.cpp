// Codebooks bred toward the best one that keeps capacities.
#include "codebook/breeding.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

#include "ccvt/capacity.h"
#include "ccvt/codebook.h"
#include "codebook/share.h"
#include "parallel/arena.h"
#include "random.h"
#include "support/generate.h"

using ccvt::Arena;
using ccvt::CodebookMethod;
using ccvt::CodebookOptions;
using ccvt::Index;
using ccvt::Points;
using ccvt::train_codebook;
using ccvt::view_points;
using namespace ccvt::test;

namespace {

/// Clouds of unequal weight that fill no whole number of capacities: where seeds matter.
Points<double> unequal_clouds(int dimension, int clouds, Index count) {
  ccvt::Random random(3, 9);
  Points<double> points(dimension, count);
  Points<double> centres(dimension, clouds);
  std::vector<double> until;
  for (int k = 0; k < clouds; ++k) {
    for (double& x : centres.col(k)) x = 8 * random.uniform();
    until.push_back((until.empty() ? 0 : until.back()) + std::pow(8, random.uniform()));
  }
  for (Index p = 0; p < count; ++p) {
    const auto k =
        std::upper_bound(until.begin(), until.end() - 1, random.uniform() * until.back()) -
        until.begin();
    for (int d = 0; d < dimension; ++d) {
      // About normal, of variance 1.
      double sum = -6;
      for (int i = 0; i < 12; ++i) sum += random.uniform();
      points(d, p) = centres(d, k) + sum;
    }
  }
  return points;
}

double trained_energy(const Points<double>& points, Index codewords, CodebookOptions options) {
  return train_codebook(points, codewords, options).summary.energy;
}

}  // namespace

TEST_SUITE_BEGIN("codebook");

TEST_CASE("with breeding the energy hardly hangs on the seed, and is lower") {
  const auto points = unequal_clouds(8, 32, 8000);
  std::vector<double> bred;
  std::vector<double> seeded;
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    bred.push_back(trained_energy(points, 32, {.seed = seed}));
    seeded.push_back(trained_energy(points, 32, {.effort = 0, .seed = seed}));
  }
  const auto [least, most] = std::minmax_element(bred.begin(), bred.end());
  const auto [lucky, unlucky] = std::minmax_element(seeded.begin(), seeded.end());
  CHECK(*most < 1.01 * *least);
  CHECK(*most - *least < (*unlucky - *lucky) / 2);
  CHECK(*least < 1.001 * *lucky);
  // More of it, and from random seeds.
  CHECK(trained_energy(points, 32, {.effort = 200}) < 1.005 * *least);
  CHECK(trained_energy(points, 32, {.seeding = ccvt::Seeding::random, .effort = 60}) <
        1.02 * *least);
}

TEST_CASE("what is bred keeps capacities, those given too, and the certificate") {
  const auto points = make_points<float>(Layout::clusters, uneven_box(3), 3000);
  for (const auto method : {CodebookMethod::exact, CodebookMethod::pairwise}) {
    for (const bool given : {false, true}) {
      CAPTURE(to_string(method));
      CodebookOptions options{.method = method, .effort = 20, .seed = 2};
      const auto capacities = given ? std::vector<Index>{1, 99, 200, 300, 400, 500, 600, 900}
                                    : ccvt::equal_capacities(3000, 8);
      options.capacities = given ? capacities : std::vector<Index>();
      const auto training = train_codebook(points, 8, options);
      std::vector<Index> sizes(8, 0);
      for (const Index code : training.codes) ++sizes[static_cast<std::size_t>(code)];
      CHECK(sizes == capacities);
      CHECK(training.summary.gap < 1e-12);
      if (method != CodebookMethod::exact) CHECK(training.codebook.weights().isZero(0));
    }
  }
}

TEST_CASE("unequal capacities are bred for as well") {
  const auto points = unequal_clouds(4, 12, 6000);
  std::vector<Index> capacities;
  for (Index k = 1; k <= 24; ++k) capacities.push_back(20 * k);
  double bred = 0;
  double seeded = 0;
  for (std::uint64_t seed = 0; seed < 3; ++seed) {
    bred += trained_energy(points, 24, {.effort = 60, .seed = seed, .capacities = capacities});
    seeded += trained_energy(points, 24, {.effort = 0, .seed = seed, .capacities = capacities});
  }
  CHECK(bred < 0.99 * seeded);
}

TEST_CASE("breeding is the same for any number of threads, and another for another seed") {
  const auto points = unequal_clouds(3, 20, 5000);
  const auto one = train_codebook(points, 24, {.threads = 1, .seed = 5});
  const auto four = train_codebook(points, 24, {.threads = 4, .seed = 5});
  CHECK(one.codes == four.codes);
  CHECK(one.codebook.codewords() == four.codebook.codewords());
  CHECK(one.codebook.weights() == four.codebook.weights());
  CHECK(train_codebook(points, 24, {.seed = 6}).codes != one.codes);
}

TEST_CASE("breeding where there is little to breed from") {
  const auto few = make_points<double>(Layout::random, uneven_box(2), 40);
  // Enough for both samples where there are few codewords.
  const auto places = make_points<double>(Layout::two_places, uneven_box(2), 1500);
  const auto place = make_points<double>(Layout::one_place, uneven_box(2), 1500);
  // The sample misses the point that is far away.
  const auto tiny = [] {
    auto points = make_points<double>(Layout::clusters, uneven_box(2), 20000);
    points *= 1e-100;
    points.col(777).setConstant(1);
    return points;
  }();
  for (const Index codewords : {1, 2, 3, 7, 40}) {
    CAPTURE(codewords);
    for (const auto* const points : {&few, &places, &place, &tiny}) {
      for (const int restarts : {0, 1}) {
        CodebookOptions options;
        options.restarts = restarts;
        options.effort = 9;
        const auto summary = train_codebook(*points, codewords, options).summary;
        CHECK(summary.usage.largest - summary.usage.smallest <= 1);
        CHECK(summary.termination == ccvt::Termination::stable);
      }
    }
  }
}

TEST_CASE("breeding ends soon when cancelled") {
  const auto points = unequal_clouds(16, 40, 20000);
  using Clock = std::chrono::steady_clock;
  const auto start = Clock::now();
  CodebookOptions options;
  options.effort = 1'000'000;
  options.cancelled = [&] { return Clock::now() - start > std::chrono::milliseconds(300); };
  const auto training = train_codebook(points, 100, options);
  CHECK(Clock::now() - start < std::chrono::seconds(3));  // on a machine that is busy, too
  CHECK(training.summary.termination == ccvt::Termination::cancelled);
  CHECK(training.summary.usage.largest == 200);
}

TEST_CASE("an even draw has every region's share") {
  const auto points = unequal_clouds(2, 30, 6000);
  std::vector<double> sites;
  for (const Index p : {5, 700, 1500, 2400, 3300, 4100, 5200}) {
    sites.insert(sites.end(), {points(0, p), points(1, p)});
  }
  const Arena arena(2);
  const auto drawn = ccvt::draw_evenly<double>(view_points(points), sites, 1000, 3, arena);
  CHECK(drawn.size() == 1000);
  CHECK(std::set<Index>(drawn.begin(), drawn.end()).size() == 1000);
  const Eigen::Map<const Eigen::MatrixXd> all(sites.data(), 2, 7);
  const auto region = [&](Index p) {
    Eigen::Index nearest = 0;
    (all.colwise() - points.col(p)).colwise().squaredNorm().minCoeff(&nearest);
    return nearest;
  };
  std::vector<double> share(7, 0);
  for (Index p = 0; p < 6000; ++p) share[static_cast<std::size_t>(region(p))] += 1 / 6.0;
  for (const Index p : drawn) share[static_cast<std::size_t>(region(p))] -= 1;
  for (const double rest : share) CHECK(std::abs(rest) <= 1);
  auto every = ccvt::draw_evenly<double>(view_points(points), sites, 6000, 3, arena);
  std::sort(every.begin(), every.end());
  std::vector<Index> numbers(6000);
  std::iota(numbers.begin(), numbers.end(), 0);
  CHECK(every == numbers);
}

TEST_SUITE_END();
