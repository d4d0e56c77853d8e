#include "metrics/slope.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "ccvt/metrics.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "random.h"
#include "support/lattices.h"

namespace ccvt::test {
namespace {

/// Power at the frequencies of the cube of 16^3 points, |f| < 1/4, each an exponential variable
/// with mean frequency^slope, averaged over sets.
std::vector<FrequencyPower> noise(double slope, int sets, Random& random) {
  std::vector<FrequencyPower> all;
  for (int z = 0; z < 4; ++z) {
    for (int y = -3; y < 4; ++y) {
      for (int x = -3; x < 4; ++x) {
        const int squared = x * x + y * y + z * z;
        if (squared >= 16 || z * 49 + y * 7 + x <= 0) continue;
        const double f = std::sqrt(squared) / 16;
        double power = 0;
        for (int s = 0; s < sets; ++s) power -= std::log(1 - random.uniform()) / sets;
        all.push_back({f, power * std::pow(f, slope)});
      }
    }
  }
  return all;
}

PointSet centroids(Distribution distribution, std::uint64_t seed) {
  const Domain torus = Domain::periodic(Box::unit(2));
  const Points<double> points = sample_uniform<double>(Box::unit(2), 400 * 100, seed, distribution);
  Problem<double> problem(points, 400);
  problem.set_domain(torus);
  Options options;
  options.seed = seed;
  return {tessellate(problem, options).sites, torus};
}

std::vector<PointSet> ten_of(Distribution distribution) {
  std::vector<PointSet> sets;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) sets.push_back(centroids(distribution, seed));
  return sets;
}

}  // namespace

TEST_SUITE_BEGIN("spectrum");

TEST_CASE("slope: digamma and trigamma are the sums that define them") {
  double harmonic = 0;
  double squares = 0;
  for (int n = 1; n <= 300; ++n) {
    CAPTURE(n);
    CHECK(digamma(n) == doctest::Approx(harmonic - std::numbers::egamma).epsilon(1e-9));
    CHECK(trigamma(n) ==
          doctest::Approx(std::numbers::pi * std::numbers::pi / 6 - squares).epsilon(1e-8));
    harmonic += 1.0 / n;
    squares += 1.0 / n / n;
  }
}

TEST_CASE("slope: shells are the lengths of whole-number vectors, as far as they lie apart") {
  Random random(1, 1);
  const auto all = noise(4, 1, random);
  const auto shells = low_shells(all);
  // 1 to 15 without 7 and 15, which are no sums of three squares.
  REQUIRE(shells.size() == 13);
  double frequencies = 0;
  for (const LowShell& shell : shells) {
    double power = 0;
    double count = 0;
    for (const FrequencyPower& each : all) {
      if (std::abs(each.frequency - shell.frequency) > 1e-9) continue;
      power += each.power;
      ++count;
    }
    CHECK(shell.frequencies == count);
    CHECK(shell.power == doctest::Approx(power / count));
    frequencies += count;
  }
  CHECK(frequencies == static_cast<double>(all.size()));
  // Nearer ones are put together.
  const auto merged = low_shells({{0.2, 5}, {0.1, 1}, {0.2039, 3}, {0.2041, 9}});
  REQUIRE(merged.size() == 3);
  CHECK(merged[1].frequencies == 2);
  CHECK(merged[1].power == 4);
  CHECK(merged[1].frequency == doctest::Approx(std::sqrt(0.2 * 0.2039)));
}

TEST_CASE("slope: the fit is unbiased, and its error tells how far off it is") {
  for (const auto& row : {std::pair{4.0, 1}, {0.0, 1}, {2.5, 10}}) {
    const double slope = row.first;
    const int sets = row.second;
    CAPTURE(slope);
    CAPTURE(sets);
    Random random(7, 1);
    constexpr int kRuns = 400;
    double off = 0;
    double squares = 0;
    double error = 0;
    double scale = 0;
    for (int run = 0; run < kRuns; ++run) {
      const PowerLaw law = fit_power_law(low_shells(noise(slope, sets, random)), sets);
      off += (law.slope - slope) / kRuns;
      squares += (law.slope - slope) * (law.slope - slope) / kRuns;
      error += law.error / kRuns;
      scale += std::log(law.scale) / kRuns;
    }
    const double spread = std::sqrt(squares);
    CHECK(std::abs(off) < 3.5 * spread / std::sqrt(kRuns));
    CHECK(error > 0.95 * spread);  // a little more, as it is never taken for less than expected
    CHECK(error < 1.25 * spread);
    CHECK(std::abs(scale) < 3.5 * 2 * spread / std::sqrt(kRuns));  // log f is about 2 off
  }
}

TEST_CASE("slope: a power law without noise is found exactly; none is told of nothing") {
  std::vector<LowShell> shells;
  for (int k = 1; k < 6; ++k) {
    const double count = k * k;
    const double bias = digamma(3 * count) - std::log(3 * count);
    shells.push_back({0.04 * k, count, 2 * std::pow(0.04 * k, 3) * std::exp(bias)});
  }
  const PowerLaw law = fit_power_law(shells, 3);
  CHECK(law.slope == doctest::Approx(3).epsilon(1e-10));
  CHECK(law.scale == doctest::Approx(2).epsilon(1e-9));
  CHECK(std::isnan(fit_power_law({shells.begin(), shells.begin() + 1}, 3).slope));
  CHECK(std::isnan(fit_power_law({}, 1).error));
}

TEST_CASE("slope: 4 for cells of jittered points, 0 for white noise, none for lattices") {
  const Spectrum cells = power_spectrum(ten_of(Distribution::jittered), {.max_frequency = 0.5});
  MESSAGE("jittered points: " << cells.low_frequency_slope << " +- "
                              << cells.low_frequency_slope_error);
  CHECK(cells.low_frequency_slope > 3.4);
  CHECK(cells.low_frequency_slope < 4.6);
  CHECK(cells.low_frequency_slope_error < 0.35);
  // White points show through.
  const Spectrum shown = power_spectrum(ten_of(Distribution::white), {.max_frequency = 0.5});
  CHECK(shown.low_frequency_slope < 1.5);
  std::vector<PointSet> noise;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) noise.push_back(white(3, 1000, seed));
  const Spectrum flat = power_spectrum(noise, {.max_frequency = 0.5});
  CHECK(std::abs(flat.low_frequency_slope) < 3 * flat.low_frequency_slope_error);
  CHECK(flat.low_frequency_slope_error < 0.5);
  CHECK(flat.low_frequency_scale * std::pow(0.2, flat.low_frequency_slope) ==
        doctest::Approx(1).epsilon(0.15));
  const PointSet grid(sample_uniform<double>(Box::unit(3), 1000, 1, Distribution::square),
                      Domain::periodic(Box::unit(3)));
  CHECK(std::isnan(power_spectrum({&grid, 1}).low_frequency_slope));
}

TEST_CASE("slope: tiles that repeat have that of one tile, in the precision of their file") {
  const PointSet tile = white(3, 1000, 1);
  Points<double> eight(3, 8000);
  for (int t = 0; t < 8; ++t) {
    const Eigen::Vector3d corner(t % 2, t / 2 % 2, t / 4);
    eight.middleCols(1000 * t, 1000) = (tile.points().colwise() + corner) / 2;
  }
  const Points<double> rounded = eight.cast<float>().cast<double>();
  const PointSet load(rounded, Domain::periodic(Box::unit(3)));
  const Spectrum one = power_spectrum({&tile, 1}, {.max_frequency = 0.5});
  const Spectrum all = power_spectrum({&load, 1}, {.max_frequency = 0.5});
  REQUIRE(all.low_shells.size() == one.low_shells.size());
  CHECK(all.low_frequency_slope == doctest::Approx(one.low_frequency_slope).epsilon(1e-4));
  CHECK(all.low_frequency_slope_error ==
        doctest::Approx(one.low_frequency_slope_error).epsilon(1e-4));
}

TEST_CASE("slope: of frequencies that are drawn, each counts once; the same for all threads") {
  std::vector<PointSet> sets;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) sets.push_back(white(4, 1500, seed));
  const Spectrum spectrum = power_spectrum(sets, {.max_frequency = 0.3, .threads = 1});
  REQUIRE(spectrum.power.empty());
  // |k| < 1.56: the 4 axes and the 12 diagonals of their planes, among 512 draws.
  REQUIRE(spectrum.low_shells.size() == 2);
  CHECK(spectrum.low_shells[0].frequencies == 4);
  CHECK(spectrum.low_shells[1].frequencies == 12);
  CHECK(std::abs(spectrum.low_frequency_slope) < 3.5 * spectrum.low_frequency_slope_error);
  for (const int threads : {2, 3}) {
    const Spectrum other = power_spectrum(sets, {.max_frequency = 0.3, .threads = threads});
    CHECK(other.low_frequency_slope == spectrum.low_frequency_slope);
    CHECK(other.low_frequency_slope_error == spectrum.low_frequency_slope_error);
  }
}

TEST_SUITE_END();

}  // namespace ccvt::test
