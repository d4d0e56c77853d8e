// What balanced codebooks are for: inverted lists. A search looks at the vectors of those lists
// whose codewords are nearest to the query, so that long lists cost it time, and a list in which
// its neighbours are but that it does not look at costs it recall.

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/io.h"
#include "paper/experiments.h"
#include "random.h"
#include "stopwatch.h"
#include "support/inverted_lists.h"
#include "support/normal.h"

#ifdef CCVT_BENCHMARK_FAISS
#include <faiss/Clustering.h>
#include <faiss/IndexFlat.h>
#include <omp.h>
#endif

namespace ccvt::bench {
namespace {

struct Codes {
  Codebook codebook;
  std::vector<Index> codes;
};

#ifdef CCVT_BENCHMARK_FAISS
/// 25 iterations, as FAISS does by default, on all vectors.
Codes faiss_codebook(const Points<float>& vectors, Index codewords, int threads) {
  omp_set_num_threads(threads > 0 ? threads : omp_get_num_procs());
  faiss::ClusteringParameters parameters;
  parameters.max_points_per_centroid = static_cast<int>(vectors.cols());
  faiss::Clustering clustering(static_cast<int>(vectors.rows()), codewords, parameters);
  faiss::IndexFlatL2 index(vectors.rows());
  clustering.train(vectors.cols(), vectors.data(), index);
  Codebook codebook(
      Eigen::Map<const Eigen::MatrixXf>(clustering.centroids.data(), vectors.rows(), codewords)
          .cast<double>());
  std::vector<Index> codes = codebook.encode(vectors, Coding::nearest, threads);
  return {std::move(codebook), std::move(codes)};
}
#endif

Codes our_codebook(const Points<float>& vectors, Index codewords, int threads,
                   CodebookMethod method) {
  CodebookOptions options;
  options.method = method;
  options.threads = threads;
  options.seed = 1;
  Training training = train_codebook(vectors, codewords, options);
  return {std::move(training.codebook), std::move(training.codes)};
}

struct Data {
  std::string name;
  Points<float> vectors;
  Points<float> queries;
  Index codewords = 0;
};

/// Gaussian clouds in 96 dimensions; their sizes fall from the first to the last, their spread
/// grows.
Data clouds(const Scale& scale) {
  constexpr int kDimension = 96;
  constexpr int kClouds = 200;
  const Index count = scale.quick ? 4096 : scale.is_long ? 1'000'000 : 131'072;
  const Index queries = scale.quick ? 200 : 2000;
  Random random(7);
  Points<float> centres(kDimension, kClouds);
  for (float& x : centres.reshaped()) x = static_cast<float>(0.35 * normal(random));
  const auto draw = [&](Index wanted) {
    Points<float> points(kDimension, wanted);
    for (Index p = 0; p < wanted; ++p) {
      const double u = random.uniform();
      const auto cloud = static_cast<Index>(u * u * kClouds);
      const double spread = 0.3 + 0.4 * cloud / kClouds;
      for (int d = 0; d < kDimension; ++d) {
        points(d, p) = centres(d, cloud) + static_cast<float>(spread * normal(random));
      }
    }
    return points;
  };
  return {"clouds " + std::to_string(count) + " x 96", draw(count), draw(queries),
          scale.quick     ? 32
          : scale.is_long ? 1024
                          : 256};
}

Data from_files(const SearchFiles& files) {
  Data data{files.vectors.stem().string(), read_points<float>(files.vectors),
            read_points<float>(files.queries), files.codewords};
  if (data.vectors.rows() != data.queries.rows()) {
    throw InvalidInput(files.queries.string() + ": has " + std::to_string(data.queries.rows()) +
                       " dimensions, but " + files.vectors.string() + " has " +
                       std::to_string(data.vectors.rows()));
  }
  if (data.codewords > data.vectors.cols()) {
    throw InvalidInput("--codewords is " + std::to_string(data.codewords) + ", but " +
                       files.vectors.string() + " has only " + std::to_string(data.vectors.cols()) +
                       " vectors");
  }
  data.name +=
      " " + std::to_string(data.vectors.cols()) + " x " + std::to_string(data.vectors.rows());
  return data;
}

Json json_of(const std::vector<Probe>& probes) {
  Json json = Json::array();
  for (const Probe& probe : probes) {
    json.push_back({{"lists", probe.lists},
                    {"recall_1", probe.recall_1},
                    {"recall_10", probe.recall_10},
                    {"scanned_mean", probe.scanned_mean},
                    {"scanned_99", probe.scanned_99}});
  }
  return json;
}

}  // namespace

void search(const Scale& scale, const std::filesystem::path& directory) {
  Record record("search", scale, directory);
  const Data data = scale.search.vectors.empty() ? clouds(scale) : from_files(scale.search);
  record.json["parameters"] = {{"data", data.name},
                               {"codewords", data.codewords},
                               {"queries", data.queries.cols()},
                               {"threads", scale.threads}};
  say("search: the nearest of " + data.name);
  const Json truth = run_in_child([&] {
    return Json{{"neighbours", true_neighbours(data.vectors, data.queries, scale.threads)}};
  });
  const auto neighbours = truth.at("neighbours").get<std::vector<std::vector<Index>>>();
  const auto measure = [&](const char* name, const auto& train) {
    say("search: " + std::string(name));
    record.json["runs"].push_back(run_in_child([&] {
      double seconds = 0;
      const Codes made = [&] {
        const Stopwatch watch(seconds);
        return train();
      }();
      const CodeUsage usage = code_usage(made.codes, made.codebook.size());
      Json run{{"codebook", name},
               {"seconds", seconds},
               {"distortion", made.codebook.distortion(data.vectors, made.codes)},
               {"shortest", usage.smallest},
               {"longest", usage.largest},
               {"imbalance", usage.imbalance}};
      for (const Coding coding : {Coding::nearest, Coding::weighted}) {
        const bool weighted = coding == Coding::weighted;
        if (weighted && made.codebook.weights().isZero(0)) continue;
        run[weighted ? "by_weight" : "by_distance"] =
            json_of(probe_lists(made.codebook, made.codes, data.queries, neighbours, coding));
      }
      return run;
    }));
    record.save();
  };
  for (const auto method : {CodebookMethod::exact, CodebookMethod::lloyd}) {
    measure(method == CodebookMethod::exact ? "balanced" : "Lloyd",
            [&] { return our_codebook(data.vectors, data.codewords, scale.threads, method); });
  }
#ifdef CCVT_BENCHMARK_FAISS
  measure("FAISS", [&] { return faiss_codebook(data.vectors, data.codewords, scale.threads); });
#endif
}

}  // namespace ccvt::bench
