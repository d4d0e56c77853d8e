#include <doctest/doctest.h>

#include <string>

#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/spectrum.h"

/// Show 5 of what makes blue noise: ten periodic runs of 1024 sites, 256 points each, default
/// options. The limits are those of the 2009 method's quality with a margin for ten runs.
namespace ccvt {
namespace {

struct Quality {
  double low_frequency_power = 0;
  double worst_anisotropy = -1000;
  double normalized_energy = 0;
  double smallest_distance = 0;
};

Quality measure(Distribution distribution) {
  constexpr int kSites = 1024;
  constexpr int kRuns = 10;
  support::RadialSpectrum spectrum(kSites);
  Quality quality;
  for (int run = 0; run < kRuns; ++run) {
    const auto seed = static_cast<std::uint64_t>(run + 1);
    const auto points = sample_uniform<float, 2>(Box::unit(2), kSites * 256, seed, distribution);
    Problem<float> problem(points, kSites);
    problem.set_domain(Domain::periodic(Box::unit(2)));
    Options options;
    options.seed = seed;
    const auto result = tessellate(problem, options);
    REQUIRE(result.summary.termination == Termination::stable);
    spectrum.add(result.sites);
    quality.normalized_energy += result.summary.normalized_energy / kRuns;
    quality.smallest_distance += support::smallest_distance(result.sites) / kRuns;
  }
  quality.low_frequency_power = spectrum.low_frequency_power();
  for (const auto& ring : spectrum.rings()) {
    if (ring.frequency - 0.0625 >= 0.875) {
      quality.worst_anisotropy = std::max(quality.worst_anisotropy, ring.anisotropy);
    }
  }
  MESSAGE("low-frequency power " << quality.low_frequency_power << ", worst anisotropy "
                                 << quality.worst_anisotropy << " dB, normalized energy "
                                 << quality.normalized_energy << ", smallest distance "
                                 << quality.smallest_distance);
  return quality;
}

TEST_CASE("white points give clean blue noise") {
  const Quality quality = measure(Distribution::white);
  CHECK(quality.worst_anisotropy < -7);
  CHECK(quality.normalized_energy <= 0.1700);
  CHECK(quality.low_frequency_power <= 0.006);
  CHECK(quality.smallest_distance >= 0.66);
}

TEST_CASE("jittered points give cleaner blue noise") {
  const Quality quality = measure(Distribution::jittered);
  CHECK(quality.worst_anisotropy < -7);
  CHECK(quality.low_frequency_power <= 0.0005);
  CHECK(quality.smallest_distance >= 0.68);
}

TEST_CASE("the spectrum knows white noise and a lattice") {
  support::RadialSpectrum white(1024);
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    white.add(sample_uniform<double, 2>(Box::unit(2), 1024, seed, Distribution::white));
  }
  for (const auto& ring : white.rings()) {
    CHECK(ring.power == doctest::Approx(1).epsilon(0.25));
    if (ring.frequency > 0.5) CHECK(ring.anisotropy == doctest::Approx(-10).epsilon(0.2));
  }
  support::RadialSpectrum lattice(1024);
  lattice.add(sample_uniform<double, 2>(Box::unit(2), 1024, 1, Distribution::square));
  CHECK(lattice.low_frequency_power() < 1e-12);
  CHECK(lattice.rings()[8].power > 1);  // the first peaks, at |f| = sqrt(n)
}

}  // namespace
}  // namespace ccvt
