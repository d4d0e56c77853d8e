// The paper's Table 1, and our own rows below it.

#include <algorithm>
#include <map>
#include <optional>

#include "ccvt/presets.h"
#include "paper/experiments.h"
#include "support/flann_pass.h"
#include "support/statistics.h"

namespace ccvt::bench {
namespace {

/// A run that is meant to tell how long a row would take.
constexpr double kProbeSeconds = 2;

struct Row {
  std::string name;
  std::string description;
  Options options;
  bool lloyd = false;
  bool paper = false;  ///< a row of the paper's table
};

struct Column {
  Index sites;
  Index points_per_site;
};

std::vector<Row> make_rows() {
  std::vector<Row> rows;
  Options relaxation;
  relaxation.threads = 1;
  rows.push_back({"lloyd", "Lloyd", relaxation, true, true});
  for (const Preset& p : paper_presets()) {
    rows.push_back({p.name, p.description, p.options, false, true});
  }
  for (const Preset& p : ablation_presets()) {
    rows.push_back({p.name, p.description, p.options, false, false});
  }
  return rows;
}

/// Seconds in Table 1, on a quad-core of 2010 (Core i7 920, 2.67 GHz).
std::optional<double> paper_seconds(const std::string& row, const std::string& column) {
  static const std::map<std::string, std::map<std::string, double>> table = {
      {"lloyd",
       {{"1024x256", 1.67}, {"4096x256", 7.66}, {"4096x1024", 32.08}, {"16384x256", 37.38}}},
      {"balzer2009", {{"1024x256", 473.72}}},
      {"balzer2009-pruned",
       {{"1024x256", 4.89}, {"4096x256", 36.70}, {"4096x1024", 292.33}, {"16384x256", 342.34}}},
      {"section4", {{"1024x256", 176.96}}},
      {"pruned",
       {{"1024x256", 2.18}, {"4096x256", 24.71}, {"4096x1024", 181.59}, {"16384x256", 280.37}}},
      {"point-distance",
       {{"1024x256", 2.20}, {"4096x256", 18.85}, {"4096x1024", 169.75}, {"16384x256", 257.78}}},
      {"multilevel",
       {{"1024x256", 1.96}, {"4096x256", 22.68}, {"4096x1024", 149.48}, {"16384x256", 340.78}}},
      {"parallel",
       {{"1024x256", 7.25}, {"4096x256", 51.55}, {"4096x1024", 262.28}, {"16384x256", 510.48}}},
      {"fast-ccvt",
       {{"1024x256", 1.53}, {"4096x256", 7.28}, {"4096x1024", 44.69}, {"16384x256", 35.75}}}};
  const auto found = table.find(row);
  if (found == table.end()) return std::nullopt;
  const auto cell = found->second.find(column);
  return cell == found->second.end() ? std::nullopt : std::optional(cell->second);
}

/// What the program of 2009 itself took for `balzer2009-pruned`, on one core and on a torus, in
/// passes of FLANN over the points: measured on another machine, by which seconds would not do.
std::optional<double> program_passes(const std::string& row, const std::string& column) {
  static const std::map<std::string, double> table = {
      {"1024x256", 11}, {"4096x256", 19}, {"4096x1024", 29}, {"16384x256", 50}};
  const auto found = table.find(column);
  if (row != "balzer2009-pruned" || found == table.end()) return std::nullopt;
  return found->second;
}

/// How long a row that examines all pairs would take: as many pairs as a pass has, times the
/// seconds that a pair takes on these points, times the passes that a sixteenth of the sites
/// needed. Random starts make the first passes the dearest, and more sites need more passes: an
/// estimate to within a small factor.
Json estimate(const Points<float>& points, Index sites, const Options& options) {
  const Index few = std::max<Index>(2, sites / 16);
  const Points<float> part = points.leftCols(points.cols() / sites * few);
  const Json small = timed_run(part, few, options, false, 2 * kProbeSeconds);
  const Json probe = timed_run(points, sites, options, false, kProbeSeconds);
  const double pairs = probe["pairs"].get<double>();
  const double per_pair = probe["seconds_relaxation"].get<double>() / std::max(1.0, pairs);
  const double n = sites;
  const double small_passes =
      small["pairs"].get<double>() / (static_cast<double>(few) * (few - 1) / 2);
  Json json;
  json["seconds_per_pair"] = per_pair;
  json["pairs_per_pass"] = n * (n - 1) / 2;
  json["passes_with_a_sixteenth_of_the_sites"] = small_passes;
  json["seconds"] = per_pair * n * (n - 1) / 2 * small_passes;
  return json;
}

/// The seconds that a row took on a smaller size, in proportion to the points: less than it would
/// take, as rows that need an estimate grow faster. 0 when it ran on none.
double in_proportion(const Json& runs, const std::string& row, double points) {
  double seconds = 0;
  for (const Json& run : runs) {
    if (run["row"] != row || !run.contains("result")) continue;
    const double fewer = run["sites"].get<double>() * run["points_per_site"].get<double>();
    seconds = run["result"]["seconds"]["median"].get<double>() * points / fewer;
  }
  return seconds;
}

/// One cell of the table: medians over the repetitions.
Json summarize(const std::vector<Json>& repetitions, const std::vector<double>& flann) {
  Json cell = repetitions.back();
  std::vector<double> seconds;
  std::vector<double> ratios;
  std::vector<double> energies;
  std::vector<double> memory;
  bool exact = true;
  for (std::size_t r = 0; r < repetitions.size(); ++r) {
    seconds.push_back(repetitions[r]["seconds"].get<double>());
    ratios.push_back(seconds.back() / flann[r]);
    energies.push_back(repetitions[r]["normalized_energy"].get<double>());
    memory.push_back(repetitions[r]["peak_memory_bytes"].get<double>());
    exact = exact && repetitions[r]["capacities_exact"].get<bool>();
  }
  cell["seconds"] = repeated(seconds);
  cell["flann_ratio"] = repeated(ratios);
  cell["normalized_energy"] = repeated(energies);
  cell["peak_memory_bytes"] = repeated(memory);
  cell["capacities_exact"] = exact;
  return cell;
}

/// Runs all rows on one size, in turn, so that a drift of the machine meets all alike.
void run_column(const Scale& scale, const std::vector<Row>& rows, const Column& column,
                Record& record) {
  const std::string name = size_name(column.sites, column.points_per_site);
  std::vector<std::vector<Json>> results(rows.size());
  std::vector<Json> estimates(rows.size());
  std::vector<double> flann;
  for (int r = 0; r < scale.repetitions; ++r) {
    const auto seed = static_cast<std::uint64_t>(r + 1);
    const Points<float> points = white_points({2, column.sites, column.points_per_site}, seed);
    flann.push_back(flann_pass(view_points(points), column.sites));
    for (std::size_t k = 0; k < rows.size(); ++k) {
      Options options = rows[k].options;
      options.seed = seed;
      if (options.threads == 0) options.threads = scale.threads;
      if (!estimates[k].is_null()) continue;
      // What took long is not repeated.
      if (r > 0 && results[k].back()["seconds"].get<double>() > scale.budget / 10) continue;
      const double least =
          in_proportion(record.json["runs"], rows[k].name, static_cast<double>(points.cols()));
      if (!scale.is_long && least > scale.budget) {
        estimates[k] = {{"seconds_at_least", least}};
        continue;
      }
      if (!scale.is_long && options.pairs == PairSelection::all && !rows[k].lloyd) {
        const Json expected = estimate(points, column.sites, options);
        if (expected["seconds"].get<double>() > scale.budget) {
          estimates[k] = expected;
          say(name + " " + rows[k].name + ": N/A");
          continue;
        }
      }
      const double limit = scale.is_long ? 0 : scale.budget;
      Json run = timed_run(points, column.sites, options, rows[k].lloyd, limit);
      if (run["termination"] == "cancelled") {
        estimates[k] = {{"seconds_at_least", scale.budget}};
        say(name + " " + rows[k].name + ": cancelled");
        continue;
      }
      say(name + " " + rows[k].name + ": " + std::to_string(run["seconds"].get<double>()) + " s");
      results[k].push_back(std::move(run));
    }
  }
  for (std::size_t k = 0; k < rows.size(); ++k) {
    Json cell;
    cell["column"] = name;
    cell["sites"] = column.sites;
    cell["points_per_site"] = column.points_per_site;
    cell["row"] = rows[k].name;
    cell["description"] = rows[k].description;
    cell["paper_row"] = rows[k].paper;
    cell["flann_seconds"] = repeated(flann);
    if (const auto seconds = paper_seconds(rows[k].name, name)) cell["paper_seconds"] = *seconds;
    if (const auto passes = program_passes(rows[k].name, name)) cell["program_passes"] = *passes;
    if (estimates[k].is_null()) {
      cell["result"] = summarize(results[k], flann);
    } else {
      cell["estimate"] = estimates[k];
    }
    record.json["runs"].push_back(std::move(cell));
  }
  record.save();
}

}  // namespace

void table1(const Scale& scale, const std::filesystem::path& directory) {
  Record record("table1", scale, directory);
  record.json["parameters"] = {{"dimension", 2},
                               {"domain", "unit torus"},
                               {"points", "white noise, float"},
                               {"seeds", "1 .. repetitions"}};
  std::vector<Column> columns = {{1024, 256}, {4096, 256}, {4096, 1024}, {16384, 256}};
  if (scale.quick) columns = {{256, 64}};
  if (!scale.only.empty()) {
    std::string sizes;
    for (const Column& c : columns) {
      sizes += (sizes.empty() ? "" : ", ") + size_name(c.sites, c.points_per_site);
    }
    std::erase_if(columns, [&](const Column& c) {
      return size_name(c.sites, c.points_per_site) != scale.only;
    });
    if (columns.empty()) {
      throw InvalidInput("--only: '" + scale.only + "' is not one of " + sizes +
                         (scale.quick ? ", which --quick has" : ""));
    }
  }
  const std::vector<Row> rows = make_rows();
  for (const Column& column : columns) run_column(scale, rows, column, record);
}

}  // namespace ccvt::bench
