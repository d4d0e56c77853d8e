#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "ccvt/metrics.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"

/// Show 5 of what makes blue noise: ten periodic runs of 1024 sites, 256 points each, default
/// options. The limits are those of the 2009 method's quality with a margin for ten runs.
namespace ccvt {
namespace {

struct Quality {
  double low_frequency_power = 0;
  double worst_anisotropy = -1000;
  double normalized_energy = 0;
  double smallest_distance = 0;
  double mean_distance = 0;
  double peak = 0;
  double psi6 = 0;
};

Quality measure(Distribution distribution) {
  constexpr int kSites = 1024;
  constexpr int kRuns = 10;
  const Domain torus = Domain::periodic(Box::unit(2));
  std::vector<PointSet> sets;
  Quality quality;
  for (int run = 0; run < kRuns; ++run) {
    const auto seed = static_cast<std::uint64_t>(run + 1);
    const auto points = sample_uniform<float, 2>(Box::unit(2), kSites * 256, seed, distribution);
    Problem<float> problem(points, kSites);
    problem.set_domain(torus);
    Options options;
    options.seed = seed;
    const auto result = tessellate(problem, options);
    REQUIRE(result.summary.termination == Termination::stable);
    sets.emplace_back(result.sites, torus);
    const NearestDistances distances = nearest_distances(sets.back());
    quality.normalized_energy += result.summary.normalized_energy / kRuns;
    quality.smallest_distance += distances.smallest / kRuns;
    quality.mean_distance += distances.mean / kRuns;
    quality.psi6 += bond_order(sets.back()).psi6_local / kRuns;
  }
  SpectrumOptions options;
  options.ring_width = 0.125;
  const Spectrum spectrum = power_spectrum(sets, options);
  quality.low_frequency_power = spectrum.low_frequency_power;
  quality.peak = spectrum.peak;
  for (const SpectrumRing& ring : spectrum.rings) {
    if (ring.lower >= 0.875) {
      quality.worst_anisotropy = std::max(quality.worst_anisotropy, ring.anisotropy_db);
    }
  }
  MESSAGE("low-frequency power " << quality.low_frequency_power << ", worst anisotropy "
                                 << quality.worst_anisotropy << " dB, normalized energy "
                                 << quality.normalized_energy << ", smallest distance "
                                 << quality.smallest_distance << ", mean distance "
                                 << quality.mean_distance << ", peak " << quality.peak << ", psi6 "
                                 << quality.psi6);
  return quality;
}

TEST_SUITE_BEGIN("quality");

TEST_CASE("white points give clean blue noise") {
  const Quality quality = measure(Distribution::white);
  CHECK(quality.worst_anisotropy < -7);
  CHECK(quality.normalized_energy <= 0.1700);
  CHECK(quality.low_frequency_power <= 0.006);
  CHECK(quality.smallest_distance >= 0.66);
  // The original program of 2009: mean distance .83, peak about 2, psi6 .43.
  CHECK(quality.mean_distance >= 0.82);
  CHECK(quality.mean_distance <= 0.86);
  CHECK(quality.peak >= 1.8);
  CHECK(quality.peak <= 2.4);
  CHECK(quality.psi6 >= 0.41);
  CHECK(quality.psi6 <= 0.50);
}

TEST_CASE("jittered points give cleaner blue noise") {
  const Quality quality = measure(Distribution::jittered);
  CHECK(quality.worst_anisotropy < -7);
  CHECK(quality.low_frequency_power <= 0.0005);
  CHECK(quality.smallest_distance >= 0.68);
}

TEST_SUITE_END();

}  // namespace
}  // namespace ccvt
