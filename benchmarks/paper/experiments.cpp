#include "paper/experiments.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "ccvt/io.h"
#include "ccvt/lloyd.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "support/machine.h"
#include "support/statistics.h"

namespace ccvt::bench {

Record::Record(std::string experiment, const Scale& scale, std::filesystem::path directory)
    : name(std::move(experiment)), file(directory / (name + ".json")) {
  json["experiment"] = name;
  json["machine"] = machine();
  json["scale"] = {{"quick", scale.quick},
                   {"long", scale.is_long},
                   {"repetitions", scale.repetitions},
                   {"budget_seconds", scale.budget}};
  json["runs"] = Json::array();
}

void Record::save() const { write_text(file, json.dump(1) + "\n"); }

Points<float> white_points(const Case& which, std::uint64_t seed) {
  return sample_uniform<float>(Box::unit(which.dimension), which.sites * which.points_per_site,
                               seed, Distribution::white);
}

Json timed_run(const Points<float>& points, Index sites, const Options& options, bool use_lloyd,
               double limit) {
  return run_in_child([&] {
    using Clock = std::chrono::steady_clock;
    Problem<float> problem(points, sites);
    problem.set_domain(Domain::periodic(Box::unit(static_cast<int>(points.rows()))));
    Options limited = options;
    const auto start = Clock::now();
    if (limit > 0) {
      limited.cancelled = [&] {
        return std::chrono::duration<double>(Clock::now() - start).count() > limit;
      };
    }
    const auto result = use_lloyd ? lloyd(problem, limited) : tessellate(problem, limited);
    const Summary& s = result.summary;
    std::vector<Index> size(static_cast<std::size_t>(sites), 0);
    for (const Index owner : result.owners) ++size[static_cast<std::size_t>(owner)];
    Json json;
    json["seconds"] = s.seconds_total;
    json["seconds_relaxation"] = s.seconds_relaxation;
    json["termination"] = to_string(s.termination);
    json["threads"] = s.threads_used;
    json["initialization"] = s.initialization_used;
    json["iterations"] = s.iterations;
    json["pairs"] = s.pairs;
    json["swaps"] = s.swaps;
    json["exchanged"] = s.exchanged;
    json["normalized_energy"] = s.normalized_energy;
    // Counted here, from the owners, not taken from the summary.
    json["capacities_exact"] = size == problem.capacities();
    json["capacity_error"] = s.capacity_error;
    return json;
  });
}

Json repeated(const std::vector<double>& values) {
  return {{"median", median(values)},
          {"least", *std::min_element(values.begin(), values.end())},
          {"most", *std::max_element(values.begin(), values.end())},
          {"all", values}};
}

void say(const std::string& text) { std::fprintf(stderr, "%s\n", text.c_str()); }

std::string size_name(Index sites, Index points_per_site) {
  return std::to_string(sites) + "x" + std::to_string(points_per_site);
}

}  // namespace ccvt::bench
