// Time and order against the points a site: what many of them cost beside as many points of more
// sites, and what they do to the sites.

#include <algorithm>
#include <cmath>
#include <numeric>

#include "ccvt/codebook.h"
#include "ccvt/lloyd.h"
#include "ccvt/metrics.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "ccvt/stipple.h"
#include "paper/experiments.h"
#include "random.h"
#include "stopwatch.h"
#include "support/flann_pass.h"
#include "support/normal.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

constexpr Index kReferencePoints = 256;  ///< a site, of the problems that others are compared with
constexpr Index kFlannPoints = 1024;     ///< a site, of the problems with a FLANN pass beside them

enum class Kind { box, torus, clouds, picture };

struct Run {
  Index sites = 0;
  Index points_per_site = 0;
  int threads = 1;
  Until until = Until::stable;
  Index largest = 0;  ///< capacity; the others fall from it. 0: all are equal
};

/// Runs in turn, of the same points; all are compared with the first.
struct Group {
  const char* table;
  std::string problem;
  Kind kind = Kind::box;
  int dimension = 2;
  std::vector<Run> runs;
};

/// What all runs of a group are given.
struct Input {
  Points<float> points;
  Image picture;
};

/// What is wanted of some problems in the box: so many seconds, or times the seconds of the
/// reference or of a FLANN pass.
struct Wanted {
  const char* size;
  const char* figure;
  double most;
};
constexpr Wanted kWanted[] = {{"64x16384", "seconds", 0.5},
                              {"256x16384", "times_reference", 1.5},
                              {"1024x4096", "times_reference", 1.4},
                              {"4096x1024", "times_flann", 0.75},
                              {"64x262144", "times_reference", 2.5}};

/// In two dimensions: clouds with random centres, some wide, some narrow, all with as many points.
Points<float> gaussian_clouds(Index count, std::uint64_t seed) {
  constexpr Index kClouds = 16;
  Random random(seed);
  Points<float> points(2, count);
  for (Index cloud = 0; cloud < kClouds; ++cloud) {
    const double x = random.uniform();
    const double y = random.uniform();
    const double deviation = 0.1 * std::pow(0.75, cloud);
    for (Index p = cloud; p < count; p += kClouds) {
      points(0, p) = static_cast<float>(x + deviation * normal(random));
      points(1, p) = static_cast<float>(y + deviation * normal(random));
    }
  }
  return points;
}

/// Dark and light rings that fade.
Image rings(int width) {
  Image image{width, width / 4 * 3, {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const double r = std::hypot(3.0 * x / width - 1, 3.0 * y / width - 1.5);
      image.values.push_back(static_cast<float>(0.5 + 0.4 * std::sin(25 * r) * std::exp(-r)));
    }
  }
  return image;
}

constexpr Index kSmallest = 29;  ///< capacity of falling_capacities()

/// `largest` and what it falls to geometrically, no less than kSmallest each, of the given sum: a
/// few sites have most of the points.
std::vector<Index> falling_capacities(Index sites, Index sum, Index largest) {
  std::vector<Index> capacities(static_cast<std::size_t>(sites));
  const auto sum_for = [&](double ratio) {
    double value = largest;
    for (Index& c : capacities) {
      c = std::max(kSmallest, static_cast<Index>(value));
      value *= ratio;
    }
    return std::accumulate(capacities.begin(), capacities.end(), std::int64_t{0});
  };
  double low = 0;
  double high = 1;
  while (std::nextafter(low, high) < high) {
    const double middle = (low + high) / 2;
    (sum_for(middle) <= sum ? low : high) = middle;
  }
  // What rounding leaves goes to others than the largest.
  std::int64_t rest = sum - sum_for(low);
  for (std::size_t s = 1; rest > 0; ++s, --rest) ++capacities.at(s);
  return capacities;
}

Input make_input(const Group& group, const Scale& scale, std::uint64_t seed) {
  const Run& first = group.runs.front();
  switch (group.kind) {
    case Kind::clouds:
      return {gaussian_clouds(first.sites * first.points_per_site, seed), {}};
    case Kind::picture:
      return {{}, rings(scale.quick ? 400 : 4000)};
    default:
      return {white_points({group.dimension, first.sites, first.points_per_site}, seed), {}};
  }
}

/// Seconds with the points drawn and the dots' radius told.
Json stippled(const Image& picture, const Run& run, const Options& options) {
  StippleOptions all;
  all.points_per_site = run.points_per_site;
  all.tessellation = options;
  double seconds = 0;
  Json json;
  {
    const Stopwatch watch(seconds);
    const Summary summary = stipple<float>(picture, run.sites, all).summary;
    json["iterations"] = summary.iterations;
    json["normalized_energy"] = summary.normalized_energy;
    json["termination"] = to_string(summary.termination);
  }
  json["seconds"] = seconds;
  return json;
}

/// The exact method of codebooks, with its default effort.
Json trained(const Input& input, const Run& run, std::uint64_t seed) {
  CodebookOptions options;
  options.threads = run.threads;
  options.seed = seed;
  const CodebookSummary summary = train_codebook(input.points, run.sites, options).summary;
  const auto dimension = static_cast<int>(input.points.rows());
  return {{"seconds", summary.seconds_total},
          {"iterations", summary.iterations},
          {"normalized_energy",
           normalized_energy(summary.energy, summary.vectors, run.sites, Box::unit(dimension))},
          {"termination", to_string(summary.termination)}};
}

Json run_once(const Group& group, const Run& run, const Input& input, std::uint64_t seed) {
  const Options options{.threads = run.threads, .seed = seed, .until = run.until};
  if (group.kind == Kind::picture) return stippled(input.picture, run, options);
  if (std::string(group.table) == "codebook") return trained(input, run, seed);
  Problem<float> problem(input.points, run.sites);
  if (group.kind == Kind::torus) problem.set_domain(Domain::periodic(Box::unit(group.dimension)));
  if (run.largest > 0) {
    problem.set_capacities(falling_capacities(run.sites, problem.points().count, run.largest));
  }
  const bool plain = std::string(group.table) == "lloyd";
  const Summary summary = (plain ? lloyd(problem, options) : tessellate(problem, options)).summary;
  return {{"seconds", summary.seconds_total},
          {"iterations", summary.iterations},
          {"normalized_energy", summary.normalized_energy},
          {"termination", to_string(summary.termination)}};
}

double flann_seconds(const Points<float>& points, Index sites) {
  return run_in_child([&] {
           return Json{{"seconds", flann_pass(view_points(points), sites)}};
         })["seconds"]
      .get<double>();
}

/// In the box: as many points a row, from one size to the next four times as many.
void add_box(std::vector<Group>& groups, bool quick) {
  for (Index points = 1 << 14; points <= (quick ? 1 << 18 : 1 << 24); points *= 4) {
    Group group{"box", "2D box", Kind::box, 2, {{points / kReferencePoints, kReferencePoints}}};
    for (const Index sites : {64, 256, 1024, 4096}) {
      const Index each = points / sites;
      if (each <= kReferencePoints || (sites == 4096 && each > kFlannPoints)) continue;
      group.runs.push_back({sites, each});
    }
    groups.push_back(std::move(group));
  }
}

void add_others(std::vector<Group>& groups, bool quick) {
  const std::vector<Run> runs = quick ? std::vector<Run>{{512, 256}, {32, 4096}}
                                      : std::vector<Run>{{16384, 256}, {1024, 4096}};
  groups.push_back({"others", "3D box", Kind::box, 3, runs});
  groups.push_back({"others", "3D torus", Kind::torus, 3, runs});
  groups.push_back({"others", "2D torus", Kind::torus, 2, runs});
  const Run few = quick ? runs[1] : Run{256, 16384};
  groups.push_back({"others", "2D Gaussian clouds", Kind::clouds, 2, {runs[0], few}});
  const Index sites = quick ? 256 : 4096;
  for (const int threads : {1, 2}) {
    const Run equal{sites, 256, threads};
    Run unequal = equal;
    unequal.largest = quick ? 14205 : 227285;
    groups.push_back({"others", "2D box", Kind::box, 2, {equal, unequal}});
  }
  for (const Until until : {Until::stable, Until::blue_noise}) {
    const Run many = quick ? Run{512, 256, 1, until} : Run{46875, 256, 1, until};
    const Run dots = quick ? Run{32, 4096, 1, until} : Run{500, 24000, 1, until};
    const char* const name = quick ? "stippling 400 x 300 pixels" : "stippling 4000 x 3000 pixels";
    groups.push_back({"others", name, Kind::picture, 2, {many, dots}});
  }
}

void add_threads(std::vector<Group>& groups, bool quick) {
  const Run one{64, quick ? 4096 : 262144, 1};
  Run two = one;
  two.threads = 2;
  groups.push_back({"threads", "2D box", Kind::box, 2, {one, two}});
}

void add_lloyd(std::vector<Group>& groups, bool quick) {
  for (const int dimension : {2, 16}) {
    std::vector<Run> runs = {{64, 1024}, {16, 4096}};
    if (!quick && dimension == 2) runs = {{65536, 16}, {16384, 64}, {1024, 1024}, {64, 16384}};
    groups.push_back({"lloyd", std::to_string(dimension) + "D box", Kind::box, dimension, runs});
  }
}

void add_codebooks(std::vector<Group>& groups, bool quick) {
  for (const int dimension : {2, 16}) {
    std::vector<Run> runs = {{64, 1024}, {16, 4096}};
    if (!quick && dimension == 2) runs = {{64, 16384}, {16, 65536}};
    groups.push_back({"codebook", std::to_string(dimension) + "D box", Kind::box, dimension, runs});
  }
}

/// The runs of that size, and the first, which they are compared with; none without them.
void keep_only(Group& group, const std::string& size) {
  std::vector<Run> kept;
  for (const Run& run : group.runs) {
    const bool that = size_name(run.sites, run.points_per_site) == size;
    if (that || kept.empty()) kept.push_back(run);
  }
  const Run& last = kept.back();
  if (size_name(last.sites, last.points_per_site) != size) kept.clear();
  group.runs = std::move(kept);
}

const char* until_name(Until until) { return until == Until::stable ? "stable" : "blue_noise"; }

Json described(const Group& group, const Run& run) {
  Json json;
  json["table"] = group.table;
  json["problem"] = group.problem;
  json["dimension"] = group.dimension;
  json["sites"] = run.sites;
  json["points_per_site"] = run.points_per_site;
  json["threads"] = run.threads;
  json["until"] = until_name(run.until);
  if (run.largest > 0) json["capacities"] = {kSmallest, run.largest};
  return json;
}

/// Those of each run of a group, a repetition after the other.
struct Measured {
  std::vector<double> seconds;
  std::vector<double> times_reference;
  std::vector<double> times_flann;
  std::vector<double> beside;  ///< seconds of one of two unrelated runs at the same time
  std::vector<Json> results;

  /// That of the run whose time is the median.
  [[nodiscard]] const Json& typical() const {
    const double middle = median(seconds);
    const auto nearer = [&](double x, double y) {
      return std::abs(x - middle) < std::abs(y - middle);
    };
    return results.at(static_cast<std::size_t>(
        std::min_element(seconds.begin(), seconds.end(), nearer) - seconds.begin()));
  }
};

void measure(const Group& group, const Input& input, std::uint64_t seed,
             std::vector<Measured>& measured) {
  for (std::size_t k = 0; k < group.runs.size(); ++k) {
    const Run& run = group.runs[k];
    Measured& own = measured[k];
    own.results.push_back(run_in_child([&] { return run_once(group, run, input, seed); }));
    const auto seconds = own.results.back()["seconds"].get<double>();
    own.seconds.push_back(seconds);
    own.times_reference.push_back(seconds / measured.front().seconds.back());
    if (std::string(group.table) == "threads" && run.threads == 1) {
      const auto both = run_side_by_side([&] { return run_once(group, run, input, seed); });
      for (const Json& one : both) own.beside.push_back(one["seconds"].get<double>());
    }
    if (std::string(group.table) == "box" && run.points_per_site == kFlannPoints) {
      own.times_flann.push_back(seconds / flann_seconds(input.points, run.sites));
    }
    say(group.problem + " " + size_name(run.sites, run.points_per_site) + ", " +
        std::to_string(run.threads) + " threads, " + until_name(run.until) + ": " +
        std::to_string(seconds) + " s");
  }
}

void add_runs(const Group& group, const std::vector<Measured>& measured, Json& runs) {
  for (std::size_t k = 0; k < group.runs.size(); ++k) {
    Json run = described(group, group.runs[k]);
    run.update(measured[k].typical());
    run["reference"] = k == 0;
    run["seconds"] = repeated(measured[k].seconds);
    run["times_reference"] = repeated(measured[k].times_reference);
    if (!measured[k].times_flann.empty()) run["times_flann"] = repeated(measured[k].times_flann);
    if (!measured[k].beside.empty()) run["beside"] = repeated(measured[k].beside);
    for (const Wanted& wanted : kWanted) {
      const std::string size = size_name(group.runs[k].sites, group.runs[k].points_per_site);
      if (std::string(group.table) != "box" || size != wanted.size) continue;
      run["wanted"] = {{"figure", wanted.figure}, {"most", wanted.most}};
    }
    runs.push_back(std::move(run));
  }
}

/// What sites of white points on the torus are like.
Json order_of(Index sites, Index points_per_site, Until until, int sets) {
  const Domain torus = Domain::periodic(Box::unit(2));
  std::vector<PointSet> all;
  std::vector<double> energies;
  std::vector<double> seconds;
  for (int r = 0; r < sets; ++r) {
    const auto seed = static_cast<std::uint64_t>(r + 1);
    const Points<float> points = white_points({2, sites, points_per_site}, seed);
    Problem<float> problem(points, sites);
    problem.set_domain(torus);
    const auto result = tessellate(problem, {.threads = 1, .seed = seed, .until = until});
    all.emplace_back(result.sites, torus);
    energies.push_back(result.summary.normalized_energy);
    seconds.push_back(result.summary.seconds_total);
  }
  const Analysis analysis = analyze(all, {.ring_width = 0.125});
  return {{"table", "order"},
          {"sites", sites},
          {"points_per_site", points_per_site},
          {"until", until_name(until)},
          {"seconds", repeated(seconds)},
          {"normalized_energy", repeated(energies)},
          {"peak", analysis.spectrum.peak},
          {"psi6", analysis.order.psi6_local},
          {"smallest_distance", analysis.distances.smallest},
          {"mean_distance", analysis.distances.mean},
          {"low_frequency_power", analysis.spectrum.low_frequency_power}};
}

void measure_order(const Scale& scale, Record& record) {
  const Index sites = scale.quick ? 256 : 1024;
  const Index most = scale.is_long ? 65536 : scale.quick ? 4096 : 16384;
  const int sets = scale.quick ? 1 : 5;
  record.json["parameters"]["order"] = {{"sites", sites}, {"sets", sets}, {"domain", "unit torus"}};
  for (Index points = scale.quick ? 256 : 64; points <= most; points *= 4) {
    if (!scale.only.empty() && size_name(sites, points) != scale.only) continue;
    for (const Until until : {Until::stable, Until::blue_noise}) {
      record.json["runs"].push_back(
          run_in_child([&] { return order_of(sites, points, until, sets); }));
      say("order " + size_name(sites, points) + ", " + until_name(until));
      record.save();
    }
  }
}

}  // namespace

void growth(const Scale& scale, const std::filesystem::path& directory) {
  Record record("growth", scale, directory);
  record.json["parameters"] = {{"points", "white noise, float"}, {"seeds", "1 .. repetitions"}};
  std::vector<Group> groups;
  add_box(groups, scale.quick);
  add_others(groups, scale.quick);
  add_threads(groups, scale.quick);
  add_lloyd(groups, scale.quick);
  add_codebooks(groups, scale.quick);
  for (Group& group : groups) {
    if (!scale.only.empty()) keep_only(group, scale.only);
    if (group.runs.empty()) continue;
    std::vector<Measured> measured(group.runs.size());
    for (int r = 0; r < scale.repetitions; ++r) {
      const auto seed = static_cast<std::uint64_t>(r + 1);
      measure(group, make_input(group, scale, seed), seed, measured);
    }
    add_runs(group, measured, record.json["runs"]);
    record.save();
  }
  measure_order(scale, record);
}

}  // namespace ccvt::bench
