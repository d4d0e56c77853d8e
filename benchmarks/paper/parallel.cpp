// How much of a run is parallel: two threads against one beside what two runs side by side show the
// machine to give, phase by phase; and what the tasks of one thread would take on more workers.

#include <chrono>
#include <cmath>
#include <vector>

#include "ccvt/codebook.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/stipple.h"
#include "ccvt/volume.h"
#include "paper/experiments.h"
#include "parallel/arena.h"
#include "random.h"
#include "stopwatch.h"
#include "support/mixture.h"
#include "support/replay.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

struct ParallelCase {
  const char* name;
  Case size;
  bool periodic = false;
  bool unequal = false;  ///< capacities, from 1 to 1000
  /// In place of a tessellation of white noise: what is timed as a whole, points drawn included,
  /// and the values it is given.
  void (*whole)(const std::vector<float>& values, const Case& size,
                const Options& options) = nullptr;
  std::vector<float> (*values)() = nullptr;
};

constexpr int kPictureSide = 1500;
constexpr int kVolumeSide = 180;

/// Of pixels: dark and light rings.
std::vector<float> rings() {
  std::vector<float> values;
  for (int y = 0; y < kPictureSide; ++y) {
    for (int x = 0; x < kPictureSide; ++x) {
      const double r = std::hypot(x - 500, y - 750);
      values.push_back(static_cast<float>(0.5 + 0.4 * std::sin(r / 60) * std::exp(-r / 900)));
    }
  }
  return values;
}

void stipple_rings(const std::vector<float>& values, const Case& size, const Options& options) {
  StippleOptions all;
  all.points_per_site = size.points_per_site;
  all.tessellation = options;
  stipple<float>({kPictureSide, kPictureSide, values}, size.sites, all);
}

/// Of voxels: a ball that is denser inside and empty around.
std::vector<float> ball() {
  constexpr double kRadius = kVolumeSide / 2;
  std::vector<float> values;
  for (int z = 0; z < kVolumeSide; ++z) {
    for (int y = 0; y < kVolumeSide; ++y) {
      for (int x = 0; x < kVolumeSide; ++x) {
        const double r = std::hypot(x - kRadius, y - kRadius, z - kRadius) / kRadius;
        values.push_back(r < 1 ? static_cast<float>(1.5 - r) : 0.0F);
      }
    }
  }
  return values;
}

void sample_ball(const std::vector<float>& values, const Case& size, const Options& options) {
  const DensityGrid grid{
      std::span<const float>(values), {kVolumeSide, kVolumeSide, kVolumeSide}, Box::unit(3)};
  VolumeOptions all;
  all.points_per_site = size.points_per_site;
  all.tessellation = options;
  sample_volume<float>(grid, size.sites, all);
}

constexpr int kVectorDimension = 64;
constexpr Index kVectors = 65536;

std::vector<float> clouds_of_vectors() {
  const Points<float> vectors = mixture(kVectors, kVectorDimension, 200);
  return {vectors.data(), vectors.data() + vectors.size()};
}

template <CodebookMethod method>
void train(const std::vector<float>& values, const Case& size, const Options& options) {
  CodebookOptions all;
  all.method = method;
  all.seed = options.seed;
  all.threads = options.threads;
  all.restarts = 1;
  const Eigen::Map<const Points<float>> vectors(values.data(), kVectorDimension, kVectors);
  train_codebook(Points<float>(vectors), size.sites, all);
}

std::vector<ParallelCase> make_cases(const Scale& scale) {
  if (scale.quick) return {{"box", {2, 512, 64}}, {"torus", {3, 512, 64}, true}};
  std::vector<ParallelCase> cases{{"box", {2, 4096, 256}}};
  for (const Index sites : {16384, 65536}) {
    for (const int dimension : {2, 3}) {
      cases.push_back({"box", {dimension, sites, 256}});
      cases.push_back({"torus", {dimension, sites, 256}, true});
    }
  }
  cases.push_back({"box, capacities 1 to 1000", {2, 16384, 256}, false, true});
  cases.push_back({"box", {16, 4096, 64}});
  cases.push_back(
      {"stippling 1500 x 1500 pixels", {2, 100000, 64}, false, false, stipple_rings, rings});
  cases.push_back({"a volume of 180^3 voxels", {3, 200000, 64}, false, false, sample_ball, ball});
  const Case codewords{kVectorDimension, 1024, kVectors / 1024};
  cases.push_back({"balanced codebook, exact", codewords, false, false,
                   train<CodebookMethod::exact>, clouds_of_vectors});
  cases.push_back({"codebook by Lloyd", codewords, false, false, train<CodebookMethod::lloyd>,
                   clouds_of_vectors});
  if (scale.is_long) {
    cases.push_back({"box", {2, 262144, 256}});
    cases.push_back({"box", {3, 262144, 256}});
  }
  return cases;
}

/// From 1 to 1000, of the given sum.
std::vector<Index> unequal_capacities(Index sites, Index sum) {
  Random random(1);
  std::vector<Index> capacities(static_cast<std::size_t>(sites));
  std::int64_t drawn = 0;
  for (Index& c : capacities) {
    const double u = random.uniform();
    drawn += c = 1 + static_cast<Index>(999 * u * u * u);
  }
  for (std::size_t s = 0; drawn != sum; s = (s + 1) % capacities.size()) {
    const Index step = drawn < sum ? 1 : -1;
    if (capacities[s] + step < 1 || capacities[s] + step > 1000) continue;
    capacities[s] += step;
    drawn += step;
  }
  return capacities;
}

Problem<float> make_problem(const ParallelCase& which, const Points<float>& points) {
  Problem<float> problem(points, which.size.sites);
  if (which.periodic) problem.set_domain(Domain::periodic(Box::unit(which.size.dimension)));
  if (which.unequal) {
    problem.set_capacities(
        unequal_capacities(which.size.sites, which.size.sites * which.size.points_per_site));
  }
  return problem;
}

Json phases_of(const Summary& summary) {
  Json json;
  for (const PhaseRecord& phase : summary.phases) {
    json[phase.name] = {
        {"seconds", phase.seconds}, {"work", phase.work_seconds}, {"tasks", phase.tasks}};
  }
  return json;
}

/// Seconds, and those of each phase of a tessellation.
Json run_once(const ParallelCase& which, const Points<float>& points, const Options& options) {
  const Summary summary = tessellate(make_problem(which, points), options).summary;
  return {{"seconds", summary.seconds_total},
          {"energy", summary.normalized_energy},
          {"phases", phases_of(summary)}};
}

Json run_whole(const ParallelCase& which, const std::vector<float>& values,
               const Options& options) {
  double seconds = 0;
  {
    const Stopwatch watch(seconds);
    which.whole(values, which.size, options);
  }
  return {{"seconds", seconds}};
}

/// Keeps so many workers busy for a while: processors that had nothing to do are slow at first, and
/// problems of a second would tell of that.
void warm_up(int threads) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(400);
  const Arena arena(threads);
  while (std::chrono::steady_clock::now() < end) {
    arena.for_each(64, 1, [](std::size_t) {
      Random random(1);
      for (int k = 0; k < 20000; ++k) random.next();
    });
  }
}

/// What a loop costs two workers beside its tasks.
double barrier_seconds() {
  const Json json = run_in_child([] {
    const Arena arena(2);
    constexpr int kLoops = 2000;
    const auto start = std::chrono::steady_clock::now();
    for (int k = 0; k < kLoops; ++k) arena.for_each(4, 1, [](std::size_t) {});
    const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - start;
    return Json{{"seconds", passed.count() / kLoops}};
  });
  return json["seconds"].get<double>();
}

/// Runs of one thread with every task timed, and what comes of their tasks on more workers.
Json replay_runs(const ParallelCase& which, int repetitions, double barrier, double slowdown) {
  return run_in_child([&] {
    const Points<float> points = white_points(which.size, 1);
    std::vector<RecordedRun> runs(static_cast<std::size_t>(repetitions));
    Json json;
    for (RecordedRun& run : runs) {
      Options options{.threads = 1, .seed = 1};
      options.on_loop = [&](const LoopRecord& loop) { run.listen(loop); };
      const Summary summary = tessellate(make_problem(which, points), options).summary;
      run.phases = summary.phases;
      json["phases"] = phases_of(summary);
    }
    const Replay replay(runs);
    for (std::size_t k = 0; k < Replay::kWorkers.size(); ++k) {
      json["predicted"][std::to_string(Replay::kWorkers[k])] =
          replay.seconds() / replay.seconds_on(k, barrier, 1);
    }
    // For the check against a measurement, tasks are as slow as runs side by side.
    json["predicted_seconds"] = replay.seconds_on(0, barrier, slowdown);
    for (auto& [name, phase] : json["phases"].items()) {
      phase["seconds"] = replay.seconds_in(name);
      phase["serial"] = replay.serial_in(name);
      phase["on_16"] = replay.parallel_in(name, 3);
      phase["on_64"] = replay.parallel_in(name, 5);
    }
    return json;
  });
}

}  // namespace

void parallel(const Scale& scale, const std::filesystem::path& directory) {
  Record record("parallel", scale, directory);
  record.json["parameters"] = {
      {"points", "white noise, float"}, {"options", "default"}, {"seed", 1}};
  const double barrier = barrier_seconds();
  record.json["barrier_seconds"] = barrier;
  for (const ParallelCase& which : make_cases(scale)) {
    const std::string size = size_name(which.size.sites, which.size.points_per_site);
    if (!scale.only.empty() && size != scale.only) continue;
    std::vector<double> one;
    std::vector<double> two;
    std::vector<double> beside;  // of two runs of one thread each, at the same time
    Json last_two;
    for (int r = 0; r < scale.repetitions; ++r) {
      constexpr std::uint64_t seed = 1;  // the same problem each time: its runs are compared
      const bool whole = which.whole != nullptr;
      const auto points = whole ? Points<float>() : white_points(which.size, seed);
      const auto values = whole ? which.values() : std::vector<float>();
      const auto run = [&](int threads) {
        const Options options{.threads = threads, .seed = seed};
        warm_up(threads);
        return whole ? run_whole(which, values, options) : run_once(which, points, options);
      };
      const auto [left, right] = run_side_by_side([&] { return run(1); });
      beside.push_back((left["seconds"].get<double>() + right["seconds"].get<double>()) / 2);
      one.push_back(run_in_child([&] { return run(1); })["seconds"].get<double>());
      last_two = run_in_child([&] { return run(2); });
      two.push_back(last_two["seconds"].get<double>());
      say(std::string(which.name) + ", " + std::to_string(which.size.dimension) + "D " + size +
          ": " + std::to_string(one.back()) + " s, " + std::to_string(two.back()) +
          " s on two threads, " + std::to_string(beside.back()) + " s side by side");
    }
    // Of medians: the machine changes between runs more than these do.
    const double slowdown = median(beside) / median(one);
    Json run;
    run["name"] = which.name;
    run["dimension"] = which.size.dimension;
    run["sites"] = which.size.sites;
    run["points_per_site"] = which.size.points_per_site;
    run["one"] = repeated(one);
    run["two"] = repeated(two);
    run["beside"] = repeated(beside);
    run["ceiling"] = 2 / slowdown;
    run["share"] = median(beside) / (2 * median(two));
    if (which.whole == nullptr) {
      const Json replay = replay_runs(which, scale.repetitions, barrier, slowdown);
      run["predicted_over_measured"] = replay["predicted_seconds"].get<double>() / median(two);
      run["predicted"] = replay["predicted"];
      run["phases"] = replay["phases"];
      run["phases_on_two"] = last_two["phases"];
    }
    record.json["runs"].push_back(std::move(run));
    record.save();
  }
}

}  // namespace ccvt::bench
