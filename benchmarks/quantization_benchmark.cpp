// Prints the rows that benchmarks/README.md quotes for quantization: ours beside published figures,
// and plain Lloyd from the same seeds. Data sets that do not ship come from a folder: see usage.

#include <sys/resource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "ccvt/sampling.h"
#include "ccvt/version.h"
#include "random.h"
#include "support/mixture.h"
#include "support/normal.h"

#ifdef CCVT_BENCHMARK_FAISS
#include <faiss/Clustering.h>
#include <faiss/IndexFlat.h>
#include <omp.h>
#endif

namespace {

using ccvt::Codebook;
using ccvt::CodebookMethod;
using ccvt::CodebookOptions;
using ccvt::Index;
using ccvt::Points;
using ccvt::bench::mixture;

double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

CodebookOptions options_for(CodebookMethod method, std::uint64_t seed, int restarts = 4) {
  CodebookOptions options;
  options.method = method;
  options.seed = seed;
  options.restarts = restarts;
  options.threads = 1;
  return options;
}

/// Show 2: the clustering basic benchmark, seeds 0 to 10, one thread.
void published(const std::filesystem::path& data) {
  struct Row {
    const char* file;
    Index codewords;
    double energy;   ///< of the best published balanced method
    double seconds;  ///< of the quickest that reaches it
  };
  std::printf("## Published data, exact sizes, one thread, restarts included\n\n");
  std::printf(
      "| data | K | published energy | published s | seeds within 0.3 %% | worst of 11 "
      "| median s | gap |\n|---|---|---|---|---|---|---|---|\n");
  for (const Row& row : {Row{"s1.csv", 15, 1.0888e13, 0.07}, Row{"a3.csv", 50, 2.9047e10, 0.17},
                         Row{"birch1.csv", 100, 9.288e13, 18.9}}) {
    if (!std::filesystem::exists(data / row.file)) continue;
    const auto points = ccvt::read_points<float>(data / row.file);
    int within = 0;
    double worst = 0;
    double gap = 0;
    std::vector<double> seconds;
    for (std::uint64_t seed = 0; seed <= 10; ++seed) {
      const auto summary =
          ccvt::train_codebook(points, row.codewords, options_for(CodebookMethod::exact, seed))
              .summary;
      const double ratio = summary.energy / row.energy;
      within += ratio <= 1.003 ? 1 : 0;
      worst = std::max(worst, ratio);
      gap = std::max(gap, summary.gap);
      seconds.push_back(summary.seconds_total);
    }
    std::sort(seconds.begin(), seconds.end());
    std::printf("| %s | %d | %.5g | %.2f | %d of 11 | %.5f | %.4f | %.1g |\n", row.file,
                row.codewords, row.energy, row.seconds, within, worst, seconds[5], gap);
    std::fflush(stdout);
  }
  std::printf("\n");
}

#ifdef CCVT_BENCHMARK_FAISS
/// Unbalanced, 25 iterations, as FAISS does by default, but on all vectors; seconds and distortion.
std::optional<std::pair<double, double>> faiss_kmeans(const Points<float>& points, Index codewords,
                                                      int threads) {
  omp_set_num_threads(threads);
  faiss::ClusteringParameters parameters;
  parameters.max_points_per_centroid = static_cast<int>(points.cols());
  faiss::Clustering clustering(static_cast<int>(points.rows()), codewords, parameters);
  faiss::IndexFlatL2 index(points.rows());
  const double seconds = seconds_of([&] { clustering.train(points.cols(), points.data(), index); });
  const double energy = static_cast<double>(clustering.iteration_stats.back().obj);
  return std::pair(seconds, energy / static_cast<double>(points.cols()));
}
#else
std::optional<std::pair<double, double>> faiss_kmeans(const Points<float>&, Index, int) {
  return {};
}
#endif

/// One data set: every method, from the same seeds before capacities count, in turn.
void compare(const char* name, const Points<float>& points, Index codewords) {
  for (const auto method :
       {CodebookMethod::exact, CodebookMethod::pairwise, CodebookMethod::lloyd}) {
    for (const int threads : {1, 2}) {
      CodebookOptions options = options_for(method, 0, 1);
      options.threads = threads;
      const auto s = ccvt::train_codebook(points, codewords, options).summary;
      std::printf("| %s | %d | %s | %d | %d | %.6g | %.4f | %lld to %lld | %.1g | %.2f | %.2f |\n",
                  name, codewords, to_string(method), threads, s.iterations, s.distortion,
                  s.usage.imbalance, static_cast<long long>(s.usage.smallest),
                  static_cast<long long>(s.usage.largest), s.gap, s.seconds_seeding,
                  s.seconds_total);
      std::fflush(stdout);
    }
  }
  if (const auto floor = faiss_kmeans(points, codewords, 1)) {
    std::printf("| %s | %d | FAISS, unbalanced | 1 | 25 | %.6g | | | | | %.2f |\n", name, codewords,
                floor->second, floor->first);
  }
}

/// Show 3 and 4.
void dimensions(const std::filesystem::path& data) {
  std::printf("## Exact against Lloyd, same seeds, to stable\n\n");
  std::printf(
      "| data | K | method | threads | iterations | distortion | imbalance | cells | gap "
      "| seeding, s | seconds |\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  compare("uniform 65536 x 2",
          ccvt::sample_uniform<float>(ccvt::Box::unit(2), 65536, 1, ccvt::Distribution::white),
          1024);
  if (std::filesystem::exists(data / "mnist10k.npy")) {
    const auto digits = ccvt::read_points<float>(data / "mnist10k.npy");
    compare("mnist10k", digits, 64);
    compare("mnist10k", digits, 256);
  }
  compare("mixture 65536 x 64", mixture(65536, 64, 200), 1024);
  std::printf(
      "\nNormalized energy of the uniform rows is K times the distortion. A published heuristic "
      "reached .1602 in 195 s, a pairwise method .1747 in 0.08 s.\n\n");
}

struct Mixture {
  int dimension;
  Index codewords;
  Index vectors;
  int clouds;
  double sizes;    ///< the largest cloud's weight over the smallest's
  double spreads;  ///< likewise, their standard deviations
  double side;     ///< of the cube that their centres lie in
};

/// Clouds of equal and unequal size and spread.
Points<float> draw(const Mixture& mixture, std::uint64_t seed) {
  ccvt::Random random(seed, 4);
  const auto clouds = static_cast<std::size_t>(mixture.clouds);
  Points<double> centres(mixture.dimension, mixture.clouds);
  std::vector<double> until(clouds);
  std::vector<double> spread(clouds);
  double sum = 0;
  for (std::size_t k = 0; k < clouds; ++k) {
    for (double& x : centres.col(static_cast<Index>(k))) x = mixture.side * random.uniform();
    until[k] = sum += std::pow(mixture.sizes, random.uniform());
    spread[k] = std::pow(mixture.spreads, random.uniform() - 0.5);
  }
  Points<float> points(mixture.dimension, mixture.vectors);
  for (auto point : points.colwise()) {
    const auto k = static_cast<std::size_t>(
        std::upper_bound(until.begin(), until.end() - 1, random.uniform() * sum) - until.begin());
    for (int d = 0; d < mixture.dimension; ++d) {
      point[d] = static_cast<float>(centres(d, static_cast<Index>(k)) +
                                    spread[k] * ccvt::bench::normal(random));
    }
  }
  return points;
}

/// Whether the result hangs on the seed: seeds 0 to 10 with and without breeding, beside the best
/// that any of these, or fifty times the effort and more, finds.
void mixtures() {
  constexpr std::array rows = {
      Mixture{2, 16, 4096, 16, 1, 1, 12},    Mixture{2, 50, 10000, 30, 8, 8, 30},
      Mixture{2, 100, 20000, 60, 16, 1, 40}, Mixture{3, 32, 8000, 24, 1, 16, 14},
      Mixture{4, 64, 16000, 40, 8, 8, 12},   Mixture{8, 32, 8000, 32, 8, 1, 8},
      Mixture{8, 100, 16000, 60, 1, 8, 8},   Mixture{16, 64, 16000, 48, 16, 16, 6},
      Mixture{32, 50, 10000, 40, 8, 4, 5},   Mixture{64, 64, 16000, 50, 8, 8, 4}};
  constexpr std::size_t kSeeds = 11;
  constexpr int kLong = 3200;
  std::printf("## Mixtures of clouds, exact sizes, seeds 0 to 10, one thread\n\n");
  std::printf(
      "| vectors | K | clouds | sizes | spreads | seeds within 0.5 %% of the best, effort 0 | "
      "worst "
      "| median s | default effort | worst | median s | effort %d |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      kLong);
  for (const Mixture& row : rows) {
    const auto points = draw(row, static_cast<std::uint64_t>(&row - rows.data()));
    CodebookOptions options = options_for(CodebookMethod::exact, 0, 0);
    options.effort = kLong;
    options.threads = 0;
    const double longest = ccvt::train_codebook(points, row.codewords, options).summary.energy;
    double best = longest;
    std::array<std::vector<double>, 2> energies;
    std::array<std::vector<double>, 2> seconds;
    for (std::size_t bred = 0; bred < 2; ++bred) {
      for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
        options = options_for(CodebookMethod::exact, seed, 0);
        if (bred == 0) options.effort = 0;
        const auto summary = ccvt::train_codebook(points, row.codewords, options).summary;
        best = std::min(best, summary.energy);
        energies[bred].push_back(summary.energy);
        seconds[bred].push_back(summary.seconds_total);
      }
      std::sort(seconds[bred].begin(), seconds[bred].end());
    }
    std::printf("| %d x %d | %d | %d | 1 : %g | 1 : %g |", row.vectors, row.dimension,
                row.codewords, row.clouds, row.sizes, row.spreads);
    for (std::size_t bred = 0; bred < 2; ++bred) {
      const auto& all = energies[bred];
      const auto within =
          std::count_if(all.begin(), all.end(), [&](double e) { return e <= 1.005 * best; });
      std::printf(
          " %d of %d | +%.2f %% | %.2f |", static_cast<int>(within), static_cast<int>(kSeeds),
          100 * (*std::max_element(all.begin(), all.end()) / best - 1), seconds[bred][kSeeds / 2]);
    }
    std::printf(" +%.2f %% |\n", 100 * (longest / best - 1));
    std::fflush(stdout);
  }
  std::printf("\n");
}

/// The peak of this process so far.
double peak_megabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1000;
}

/// Sizes of vector search, a process each for the sake of the peak: Lloyd first, which needs less;
/// FAISS last, without a peak of its own.
bool large(const std::string& name, const std::filesystem::path& data) {
  struct Row {
    const char* name;
    Index vectors;
    int dimension;
    int clouds;
    Index codewords;
    double gap;
  };
  Points<float> points;
  Row row{"mnist", 0, 784, 0, 256, 0};
  if (name == row.name) {
    points = ccvt::read_points<float>(data / "mnist_train.npy");
  } else {
    const std::array rows = {
        Row{"4096", 65536, 64, 200, 4096, 0}, Row{"1M", 1'000'000, 128, 500, 1024, 0},
        Row{"16384", 1'000'000, 96, 500, 16384, 1e-3}, Row{"65536", 262'144, 32, 500, 65536, 1e-3}};
    const auto* const found = std::find_if(
        rows.begin(), rows.end(), [&](const Row& candidate) { return name == candidate.name; });
    if (found == rows.end()) return false;
    row = *found;
    points = mixture(row.vectors, row.dimension, row.clouds);
  }
  std::printf(
      "| vectors | K | method | threads | iterations | distortion | imbalance | gap "
      "| seeding, s | seconds | peak, MB | of which vectors |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (const auto method : {CodebookMethod::lloyd, CodebookMethod::exact}) {
    CodebookOptions options = options_for(method, 0, 1);
    options.threads = 0;
    options.gap = method == CodebookMethod::exact ? row.gap : 0;
    const auto s = ccvt::train_codebook(points, row.codewords, options).summary;
    std::printf(
        "| %d x %d | %d | %s | %d | %d | %.6g | %.4f | %.1g | %.1f | %.1f | %.0f | %.0f |\n",
        s.vectors, s.dimension, row.codewords, to_string(method), s.threads_used, s.iterations,
        s.distortion, s.usage.imbalance, s.gap, s.seconds_seeding, s.seconds_total,
        peak_megabytes(), 4e-6 * static_cast<double>(points.size()));
    std::fflush(stdout);
  }
  const int threads = static_cast<int>(std::thread::hardware_concurrency());
  if (const auto floor = faiss_kmeans(points, row.codewords, threads)) {
    std::printf("| %d x %d | %d | FAISS, unbalanced | %d | 25 | %.6g | | | | %.1f | | |\n",
                static_cast<int>(points.cols()), static_cast<int>(points.rows()), row.codewords,
                threads, floor->second, floor->first);
  }
  return true;
}

/// Show 6: new vectors, by weight and nearest, beside a bare matrix product.
void encoding() {
  std::printf("## Encoding new vectors, one thread\n\n");
  std::printf(
      "| data | K | coding | imbalance | vectors a second | of the product's rate |\n"
      "|---|---|---|---|---|---|\n");
  for (const int dimension : {2, 64}) {
    const Points<float> all = mixture(131072, dimension, 200);
    const Points<float> seen = all.leftCols(65536);
    const Points<float> fresh = all.rightCols(65536);
    constexpr Index kCodewords = 256;
    const auto training =
        ccvt::train_codebook(seen, kCodewords, options_for(CodebookMethod::exact, 0, 1));
    const Eigen::MatrixXf words = training.codebook.codewords().cast<float>();
    Eigen::MatrixXf product(kCodewords, 1024);
    const double bound = seconds_of([&] {
      for (Eigen::Index k = 0; k < fresh.cols(); k += 1024) {
        product.noalias() = words.transpose() * fresh.middleCols(k, 1024);
      }
    });
    for (const auto coding : {ccvt::Coding::weighted, ccvt::Coding::nearest}) {
      std::vector<Index> codes;
      const double seconds =
          seconds_of([&] { codes = training.codebook.encode(fresh, coding, 1); });
      std::printf("| mixture, D = %d | %d | %s | %.3f | %.3g | %.2f |\n", dimension, kCodewords,
                  coding == ccvt::Coding::weighted ? "weighted" : "nearest",
                  ccvt::code_usage(codes, kCodewords).imbalance, 65536 / seconds, bound / seconds);
    }
  }
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  std::string what = "all";
  std::filesystem::path data;
  std::string large_row;
  for (int k = 1; k < argc; ++k) {
    const std::string argument = argv[k];
    if (argument == "large" && k + 1 < argc) {
      what = argument;
      large_row = argv[++k];
    } else if (argument == "--data" && k + 1 < argc) {
      data = argv[++k];
    } else if (argument == "all" || argument == "published" || argument == "dimensions" ||
               argument == "encoding" || argument == "mixtures") {
      what = argument;
    } else {
      std::fprintf(stderr,
                   "usage: quantization_benchmark [all|published|dimensions|encoding|mixtures] "
                   "[--data FOLDER]\n"
                   "       quantization_benchmark large 4096|mnist|1M|16384|65536 [--data FOLDER]\n"
                   "FOLDER holds s1.csv, a3.csv, birch1.csv and mnist10k.npy; rows of files that "
                   "are not there are left out; large mnist wants mnist_train.npy\n");
      return 2;
    }
  }
  std::printf("ccvt %s, %s\n\n", CCVT_VERSION, __VERSION__);
  if (what == "large" && !large(large_row, data)) {
    std::fprintf(stderr, "large: no row %s\n", large_row.c_str());
    return 2;
  }
  if (what == "all" || what == "published") published(data);
  if (what == "all" || what == "dimensions") dimensions(data);
  if (what == "all" || what == "encoding") encoding();
  if (what == "mixtures") mixtures();
  return 0;
}
