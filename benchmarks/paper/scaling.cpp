// Time against the size of a problem, threads and dimensions, with default options.

#include <algorithm>
#include <thread>

#include "paper/experiments.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

/// Cases that differ in one thing.
struct Sweep {
  std::string name;
  std::vector<Case> cases;
  std::vector<int> threads;  ///< of each case
};

std::vector<Sweep> make_sweeps(const Scale& scale) {
  std::vector<Sweep> sweeps;
  const auto add = [&](const std::string& name) -> Sweep& {
    return sweeps.emplace_back(Sweep{name, {}, {}});
  };
  const auto add_case = [](Sweep& sweep, const Case& which, int threads) {
    sweep.cases.push_back(which);
    sweep.threads.push_back(threads);
  };
  const Index most = scale.is_long ? 1 << 20 : scale.quick ? 2048 : 1 << 18;
  for (const int dimension : {2, 3}) {
    Sweep& sweep = add("sites, " + std::to_string(dimension) + "D");
    for (Index n = scale.quick ? 512 : 1024; n <= most; n *= scale.quick ? 2 : 4) {
      add_case(sweep, {dimension, n, scale.quick ? 64 : 256}, scale.threads);
    }
  }
  Sweep& density = add("points per site");
  for (const Index points : {16, 64, 256, 1024}) {
    if (scale.quick && points > 64) continue;
    add_case(density, {2, scale.quick ? 512 : 4096, points}, scale.threads);
  }
  const int all =
      scale.threads > 0 ? scale.threads : static_cast<int>(std::thread::hardware_concurrency());
  Sweep& threads = add("threads");
  for (int t = 1; t <= std::max(1, all); t = t < all ? std::min(2 * t, all) : t + 1) {
    add_case(threads, {2, scale.quick ? 1024 : 16384, scale.quick ? 64 : 256}, t);
  }
  Sweep& dimensions = add("dimensions");
  for (const int dimension : {2, 3, 4, 8, 16, 64, 128}) {
    if (scale.quick && dimension > 8) continue;
    add_case(dimensions, {dimension, scale.quick ? 256 : 1024, scale.quick ? 16 : 64},
             scale.threads);
  }
  return sweeps;
}

}  // namespace

void scaling(const Scale& scale, const std::filesystem::path& directory) {
  Record record("scaling", scale, directory);
  record.json["parameters"] = {{"domain", "unit torus"},
                               {"points", "white noise, float"},
                               {"options", "default"},
                               {"seeds", "1 .. repetitions"}};
  for (const Sweep& sweep : make_sweeps(scale)) {
    std::vector<std::vector<double>> seconds(sweep.cases.size());
    std::vector<Json> last(sweep.cases.size());
    for (int r = 0; r < scale.repetitions; ++r) {
      const auto seed = static_cast<std::uint64_t>(r + 1);
      for (std::size_t k = 0; k < sweep.cases.size(); ++k) {
        if (r > 0 && seconds[k].back() > scale.budget / 20) continue;  // once is enough
        const Case& which = sweep.cases[k];
        const Points<float> points = white_points(which, seed);
        last[k] =
            timed_run(points, which.sites, {.threads = sweep.threads[k], .seed = seed}, false, 0);
        seconds[k].push_back(last[k]["seconds"].get<double>());
        say(sweep.name + ": " + std::to_string(which.dimension) + "D " +
            size_name(which.sites, which.points_per_site) + ": " +
            std::to_string(seconds[k].back()) + " s");
      }
    }
    for (std::size_t k = 0; k < sweep.cases.size(); ++k) {
      Json run = last[k];
      run["sweep"] = sweep.name;
      run["dimension"] = sweep.cases[k].dimension;
      run["sites"] = sweep.cases[k].sites;
      run["points_per_site"] = sweep.cases[k].points_per_site;
      run["threads"] = sweep.threads[k] > 0 ? Json(sweep.threads[k]) : run["threads"];
      run["seconds"] = repeated(seconds[k]);
      record.json["runs"].push_back(std::move(run));
    }
    record.save();
  }
}

}  // namespace ccvt::bench
