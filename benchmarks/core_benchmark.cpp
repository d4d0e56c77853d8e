// Prints the figures that README.md and benchmarks/README.md quote for the core of the library.

#include <sys/resource.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "ccvt/metrics.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/version.h"
#include "stopwatch.h"
#include "support/flann_pass.h"
#include "support/statistics.h"

namespace {

using ccvt::Box;
using ccvt::Distribution;
using ccvt::Index;
using ccvt::Options;
using ccvt::bench::flann_pass;
using ccvt::bench::median;

double seconds_of(const std::function<void()>& work) {
  double seconds = 0;
  {
    const ccvt::Stopwatch watch(seconds);
    work();
  }
  return seconds;
}

double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

/// Default options, one thread, unit square, white noise, float; in turn with the FLANN pass.
void speed(int repetitions) {
  std::printf("## Speed: one thread, 2D square, float, white noise, to stable\n\n");
  std::printf(
      "| sites x points a site | seconds | FLANN pass, s | ratio | iterations "
      "| normalized energy |\n|---|---|---|---|---|---|\n");
  for (const auto& [sites, capacity] :
       {std::pair{1024, 256}, {4096, 256}, {4096, 1024}, {16384, 256}}) {
    std::vector<double> ours;
    std::vector<double> theirs;
    std::vector<double> ratios;
    ccvt::Summary last;
    for (int r = 0; r < repetitions; ++r) {
      const auto seed = static_cast<std::uint64_t>(r + 1);
      const auto points =
          ccvt::sample_uniform<float, 2>(Box::unit(2), sites * capacity, seed, Distribution::white);
      theirs.push_back(flann_pass(ccvt::view_points(points), sites));
      last = ccvt::tessellate(points, sites, {.threads = 1, .seed = seed}).summary;
      ours.push_back(last.seconds_total);
      ratios.push_back(ours.back() / theirs.back());
    }
    std::printf("| %d x %d | %.3f | %.3f | %.2f | %d | %.4f |\n", sites, capacity, median(ours),
                median(theirs), median(ratios), last.iterations, last.normalized_energy);
    std::fflush(stdout);
  }
  std::printf("\nMedians of %d runs with different points, each next to its FLANN pass.\n\n",
              repetitions);
}

/// What each choice in the default options is worth: the same points for every row.
void choices(int repetitions) {
  struct Row {
    const char* name;
    Options options;
  };
  Options coherent{.threads = 1, .initialization = ccvt::Initialization::coherent};
  Options coherent_flat = coherent;
  coherent_flat.multilevel = false;
  Options paper = Options::fast_ccvt();
  paper.threads = 1;
  const std::vector<Row> rows{
      {"default", {.threads = 1}},
      {"two threads", {.threads = 2}},
      {"one level", {.threads = 1, .multilevel = false}},
      {"coherent start", coherent},
      {"coherent start, one level", coherent_flat},
      {"pair cache, 5 passes", {.threads = 1, .cached_passes = 5}},
      {"tiles of one site", {.threads = 1, .tile_sites = 1}},
      {"heap swap", {.threads = 1, .swap = ccvt::SwapMethod::heap}},
      {"point distance pruning", {.threads = 1, .point_pruning = ccvt::PointPruning::distance}},
      {"the paper's fast CCVT", paper},
  };
  constexpr Index kSites = 4096;
  std::printf("## Choices: %d sites x 256, torus, float, white noise, to stable\n\n", kSites);
  std::printf(
      "| options | seconds | of default | iterations | pairs examined | points exchanged "
      "| normalized energy |\n|---|---|---|---|---|---|---|\n");
  std::vector<std::vector<double>> times(rows.size());
  std::vector<ccvt::Summary> last(rows.size());
  for (int r = 0; r < repetitions; ++r) {
    const auto seed = static_cast<std::uint64_t>(r + 1);
    const auto points =
        ccvt::sample_uniform<float, 2>(Box::unit(2), kSites * 256, seed, Distribution::white);
    ccvt::Problem<float> problem(points, kSites);
    problem.set_domain(ccvt::Domain::periodic(Box::unit(2)));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      Options options = rows[k].options;
      options.seed = seed;
      last[k] = ccvt::tessellate<2>(problem, options).summary;
      times[k].push_back(last[k].seconds_total);
    }
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    std::printf("| %s | %.3f | %.2f | %d | %lld | %lld | %.4f |\n", rows[k].name, median(times[k]),
                median(times[k]) / median(times[0]), last[k].iterations,
                static_cast<long long>(last[k].pairs), static_cast<long long>(last[k].exchanged),
                last[k].normalized_energy);
  }
  std::printf("\nMedians of %d runs, rows in turn; the other figures are of the last run.\n\n",
              repetitions);
}

/// Ten runs of 1024 sites x 256 on the torus, beside the figures of the 2009 program.
void quality() {
  std::printf("## Quality: 1024 sites x 256, torus, default options, 10 runs\n\n");
  std::printf(
      "| points | smallest distance | mean distance | mean power below .25 sqrt(n) "
      "| spectral peak | effective Nyquist | worst anisotropy beyond .875 sqrt(n), dB "
      "| local psi6 | six-sided | normalized energy "
      "|\n|---|---|---|---|---|---|---|---|---|---|\n");
  const auto torus = ccvt::Domain::periodic(Box::unit(2));
  for (const auto distribution : {Distribution::white, Distribution::jittered}) {
    std::vector<ccvt::PointSet> sets;
    double energy = 0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const auto points =
          ccvt::sample_uniform<float, 2>(Box::unit(2), 1024 * 256, seed, distribution);
      ccvt::Problem<float> problem(points, 1024);
      problem.set_domain(torus);
      const auto result = ccvt::tessellate<2>(problem, {.seed = seed});
      sets.emplace_back(result.sites, torus);
      energy += result.summary.normalized_energy / 10;
    }
    const ccvt::Analysis analysis = ccvt::analyze(sets, {.ring_width = 0.125});
    double worst = -1000;
    for (const auto& ring : analysis.spectrum.rings) {
      if (ring.lower >= 0.875) worst = std::max(worst, ring.anisotropy_db);
    }
    std::printf("| %s | %.3f | %.3f | %.5f | %.2f | %.2f | %.2f | %.3f | %.3f | %.4f |\n",
                distribution == Distribution::white ? "white" : "jittered",
                analysis.distances.smallest, analysis.distances.mean,
                analysis.spectrum.low_frequency_power, analysis.spectrum.peak,
                analysis.spectrum.effective_nyquist, worst, analysis.order.psi6_local,
                analysis.order.six_sided, energy);
  }
  std::printf(
      "| the program of 2009 | .67 | .83 | .004 to .005 | about 2 | | | .43 | | .1712 |\n\n");
  std::printf(
      "Distances as shares of the hexagonal lattice's; rings of width .125 sqrt(n). The last row "
      "was measured\non the original program.\n\n");
}

/// The exact periodogram up to |f| = 2 n^(1/D), and all of analyze().
void metrics(int repetitions) {
  std::printf("## Metrics: white noise on the torus, two threads\n\n");
  std::printf(
      "| D | points | frequencies | spectrum, s | all metrics, s |\n|---|---|---|---|---|\n");
  for (const auto& [dimension, count] :
       {std::pair{2, 1024}, {2, 4096}, {2, 16384}, {3, 4096}, {4, 4096}}) {
    const Box box = Box::unit(dimension);
    const ccvt::PointSet set(ccvt::sample_uniform<double>(box, count, 1, Distribution::white),
                             ccvt::Domain::periodic(box));
    double spectrum_seconds = 1e9;
    double all_seconds = 1e9;
    ccvt::Spectrum spectrum;
    for (int r = 0; r < repetitions; ++r) {
      spectrum_seconds = std::min(spectrum_seconds, seconds_of([&] {
                                    spectrum = ccvt::power_spectrum({&set, 1}, {.threads = 2});
                                  }));
      all_seconds = std::min(all_seconds, seconds_of([&] {
                               ccvt::analyze({&set, 1}, {.threads = 2});
                             }));
    }
    std::printf(
        "| %d | %d | %zu | %.3f | %.3f |\n", dimension, count,
        spectrum.power.empty() ? spectrum.rings.size() * 128 + 512 : spectrum.power.size() / 2,
        spectrum_seconds, all_seconds);
    std::fflush(stdout);
  }
  std::printf("\nLeast of %d runs. In 4D frequencies are drawn.\n\n", repetitions);
}

/// Time against dimension: 1024 sites x 64, jittered, Euclidean.
void dimensions() {
  std::printf("## Dimensions: 1024 sites x 64, unit cube, float, one thread, to stable\n\n");
  std::printf(
      "| D | seconds | start | iterations | pairs examined | energy / start energy |\n"
      "|---|---|---|---|---|---|\n");
  for (const int dimension : {1, 2, 3, 4, 8, 16, 64, 128}) {
    const auto points = ccvt::sample_uniform<float>(Box::unit(dimension), 1024 * 64, 1);
    const auto s = ccvt::tessellate(points, 1024, {.threads = 1}).summary;
    std::printf("| %d | %.3f | %s | %d | %lld | %.3f |\n", dimension, s.seconds_total,
                s.initialization_used.c_str(), s.iterations, static_cast<long long>(s.pairs),
                s.energy / s.initial_energy);
    std::fflush(stdout);
  }
  std::printf("\n");
}

/// Peak memory of this whole process, points and result included.
void memory(Index sites) {
  const Index count = sites * 256;
  const auto points = ccvt::sample_uniform<float, 2>(Box::unit(2), count, 1, Distribution::white);
  const auto result = ccvt::tessellate(points, sites, {.threads = 1});
  const double coordinates = 2.0 * sizeof(float) * count / (1024 * 1024);
  std::printf("## Memory: %d sites x 256, 2D, float\n\n", sites);
  std::printf(
      "coordinates %.0f MB, peak of the process %.0f MB: (peak - 100 MB) / coordinates = "
      "%.2f (%s)\n\n",
      coordinates, peak_megabytes(), (peak_megabytes() - 100) / coordinates,
      to_string(result.summary.termination));
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc > 1 ? argv[1] : "all";
  const int repetitions = argc > 2 ? std::max(1, std::atoi(argv[2])) : 5;
  const bool all = what == "all";
  std::printf("ccvt %s, %s\n\n", CCVT_VERSION, __VERSION__);
  if (all || what == "speed") speed(repetitions);
  if (all || what == "choices") choices(repetitions);
  if (all || what == "quality") quality();
  if (all || what == "metrics") metrics(repetitions);
  if (all || what == "dimensions") dimensions();
  if (all || what == "memory") memory(65536);
  const std::vector<std::string> known{"all",     "speed",      "choices", "quality",
                                       "metrics", "dimensions", "memory"};
  if (std::find(known.begin(), known.end(), what) == known.end()) {
    std::fprintf(
        stderr,
        "usage: core_benchmark [all|speed|choices|quality|metrics|dimensions|memory] [RUNS]\n");
    return 2;
  }
  return 0;
}
