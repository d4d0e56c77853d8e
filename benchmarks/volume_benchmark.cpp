// Prints the figures that README.md and benchmarks/README.md quote for three dimensions.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/density.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/version.h"
#include "support/flann_pass.h"

namespace {

using ccvt::Box;
using ccvt::Index;

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

/// Distances of sites on the unit torus to their nearest site, over the spacing of the densest
/// packing of as many: in the face-centred cubic lattice, (sqrt(2) / n)^(1/3).
struct Spacing {
  double least = std::numeric_limits<double>::infinity();
  double mean = 0;

  explicit Spacing(const Eigen::Matrix3Xf& sites) {
    const double densest = std::cbrt(std::sqrt(2.0) / static_cast<double>(sites.cols()));
    for (Eigen::Index a = 0; a < sites.cols(); ++a) {
      double nearest = std::numeric_limits<double>::infinity();
      for (Eigen::Index b = 0; b < sites.cols(); ++b) {
        if (a == b) continue;
        const Eigen::Array3d d = (sites.col(a) - sites.col(b)).cast<double>().array();
        nearest = std::min(nearest, (d - d.round()).square().sum());
      }
      least = std::min(least, std::sqrt(nearest) / densest);
      mean += std::sqrt(nearest) / densest / static_cast<double>(sites.cols());
    }
  }
};

/// How fast this machine is just now: millions of points a second for which FLANN finds the nearest
/// of 16384 sites, on one thread.
double flann_rate(std::uint64_t seed) {
  constexpr Index kPoints = 1'000'000;
  const auto points =
      ccvt::sample_uniform<float>(Box::unit(3), kPoints, seed, ccvt::Distribution::white);
  return 1e-6 * kPoints / ccvt::bench::flann_pass(ccvt::view_points(points), 16384);
}

/// Uniform sites on the torus, one thread.
void uniform(int repetitions) {
  std::printf("## Uniform 3D: torus, float, one thread, to stable\n\n");
  std::printf(
      "| sites x points a site | points | seconds | million FLANN queries | normalized energy, "
      "worst | smallest distance / FCC, worst | mean distance / FCC, worst "
      "|\n|---|---|---|---|---|---|---|\n");
  for (const auto& [sites, capacity] : {std::pair{1000, 256}, {8000, 64}}) {
    for (const auto distribution : {ccvt::Distribution::jittered, ccvt::Distribution::white}) {
      std::vector<double> seconds;
      std::vector<double> queries;
      double energy = 0;
      double least = 1;
      double mean = 1;
      for (int r = 0; r < repetitions; ++r) {
        const auto seed = static_cast<std::uint64_t>(r + 1);
        const double rate = flann_rate(seed);
        const auto points =
            ccvt::sample_uniform<float, 3>(Box::unit(3), sites * capacity, seed, distribution);
        ccvt::Problem<float> problem(points, sites);
        problem.set_domain(ccvt::Domain::periodic(Box::unit(3)));
        const auto result = ccvt::tessellate<3>(problem, {.threads = 1, .seed = seed});
        const Spacing spacing(result.sites);
        seconds.push_back(result.summary.seconds_total);
        queries.push_back(seconds.back() * rate);
        energy = std::max(energy, result.summary.normalized_energy);
        least = std::min(least, spacing.least);
        mean = std::min(mean, spacing.mean);
      }
      std::printf("| %d x %d | %s | %.3f | %.2f | %.4f | %.3f | %.3f |\n", sites, capacity,
                  distribution == ccvt::Distribution::white ? "white" : "jittered", median(seconds),
                  median(queries), energy, least, mean);
      std::fflush(stdout);
    }
  }
  std::printf(
      "\nMedians of %d runs with different points. A million FLANN queries: the seconds times the "
      "million points\na second for which FLANN found the nearest of 16384 sites just before the "
      "run.\n\n",
      repetitions);
}

template <int Dimension>
double seconds_in(Index sites, std::uint64_t seed) {
  const auto points = ccvt::sample_uniform<float, Dimension>(Box::unit(Dimension), sites * 256,
                                                             seed, ccvt::Distribution::white);
  return ccvt::tessellate(points, sites, {.threads = 1, .seed = seed}).summary.seconds_total;
}

/// Three dimensions against two, in turn.
void ratio(int repetitions) {
  constexpr Index kSites = 16384;
  std::printf(
      "## 3D over 2D: %d sites x 256, unit cube and square, float, white noise, one thread, ",
      kSites);
  std::printf("to stable\n\n| 3D, s | 2D, s | ratio |\n|---|---|---|\n");
  std::vector<double> ratios;
  for (int r = 0; r < repetitions; ++r) {
    const auto seed = static_cast<std::uint64_t>(r + 1);
    const double two = seconds_in<2>(kSites, seed);
    const double three = seconds_in<3>(kSites, seed);
    ratios.push_back(three / two);
    std::printf("| %.2f | %.2f | %.2f |\n", three, two, ratios.back());
    std::fflush(stdout);
  }
  std::printf("\nMedian ratio %.2f.\n\n", median(ratios));
}

/// What drawing points from a grid costs.
void density() {
  constexpr std::int64_t kSide = 256;
  const std::vector<std::int64_t> shape(3, kSide);
  std::vector<std::uint8_t> values(static_cast<std::size_t>(kSide * kSide * kSide));
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = static_cast<std::uint8_t>(i * 2654435761U >> 24U);
  }
  ccvt::DensityGrid grid{values, shape, Box::unit(3)};
  grid.interpolation = ccvt::Interpolation::linear;
  std::printf("## Points from a grid of 256^3 bytes, multilinear, float, one thread\n\n");
  std::printf("| points | sampling | seconds | ns a cell |\n|---|---|---|---|\n");
  for (const Index count : {1, 100'000, 5'000'000}) {
    for (const auto sampling : {ccvt::DensitySampling::white, ccvt::DensitySampling::stratified}) {
      const auto start = std::chrono::steady_clock::now();
      const auto points = ccvt::sample_density<float, 3>(grid, count, 1, sampling, 1);
      const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
      std::printf("| %d | %s | %.3f | %.1f |\n", static_cast<int>(points.cols()),
                  sampling == ccvt::DensitySampling::white ? "white" : "stratified", time.count(),
                  1e9 * time.count() / static_cast<double>(values.size()));
    }
  }
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "all";
  const int repetitions = argc > 2 ? std::max(1, std::atoi(argv[2])) : 3;
  const std::vector<std::string> known{"all", "uniform", "ratio", "density"};
  if (std::find(known.begin(), known.end(), what) == known.end()) {
    std::fprintf(stderr, "usage: volume_benchmark [all|uniform|ratio|density] [RUNS]\n");
    return 2;
  }
  std::printf("ccvt %s, %s\n\n", CCVT_VERSION, __VERSION__);
  const bool all = what == "all";
  if (all || what == "uniform") uniform(repetitions);
  if (all || what == "ratio") ratio(repetitions);
  if (all || what == "density") density();
  return 0;
}
