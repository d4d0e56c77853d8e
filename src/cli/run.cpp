#include "cli/run.h"

#include <algorithm>
#include <iostream>
#include <nlohmann/json.hpp>

#include "ccvt/presets.h"
#include "ccvt/version.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/rank_json.h"
#include "cli/signals.h"
#include "cli/standard_streams.h"
#include "cli/streams.h"
#include "number_text.h"

namespace ccvt::cli {

namespace {

nlohmann::ordered_json json_of(const MassFigures& masses) {
  return {{"method", masses.method},
          {"total", masses.total},
          {"largest_error", masses.largest_error},
          {"worst_site", masses.worst_site},
          {"error_bound", masses.error_bound},
          {"relative_error", masses.relative_error},
          {"shared_points", masses.shared_points}};
}

std::string summary_json(const std::string& command, const Summary& summary,
                         const std::optional<PutBack>& put_back,
                         const std::optional<MassFigures>& masses,
                         const std::optional<RankFigures>& ranks) {
  nlohmann::ordered_json json;
  json["version"] = CCVT_VERSION;
  json["command"] = command;
  json["dimension"] = summary.dimension;
  json["points"] = summary.points;
  json["sites"] = summary.sites;
  json["seed"] = summary.seed;
  json["threads"] = summary.threads_used;
  json["initialization"] = summary.initialization_used;
  json["levels"] = summary.levels;
  json["termination"] = to_string(summary.termination);
  json["iterations"] = summary.iterations;
  json["pairs"] = summary.pairs;
  json["swaps"] = summary.swaps;
  json["exchanged"] = summary.exchanged;
  json["initial_energy"] = summary.initial_energy;
  json["energy"] = summary.energy;
  json["normalized_energy"] = summary.has_normalized_energy()
                                  ? nlohmann::ordered_json(summary.normalized_energy)
                                  : nlohmann::ordered_json(nullptr);
  json["capacity_error"] = summary.capacity_error;
  json["seconds"] = {{"total", summary.seconds_total},
                     {"initialization", summary.seconds_initialization},
                     {"relaxation", summary.seconds_relaxation}};
  for (const PhaseRecord& phase : summary.phases) {
    json["phases"][phase.name] = {{"seconds", phase.seconds},
                                  {"work_seconds", phase.work_seconds},
                                  {"loops", phase.loops},
                                  {"tasks", phase.tasks}};
  }
  json["peak_memory_bytes"] = peak_memory_bytes();
  if (put_back) {
    json["put_back"] = {{"sites", put_back->sites}, {"farthest", put_back->farthest}};
  }
  if (masses) json["masses"] = json_of(*masses);
  if (ranks) json["ranks"] = json_of(*ranks);
  json["warnings"] = summary.warnings;
  // JSON has no infinity and no NaN; the library writes null for them.
  return json.dump(2) + "\n";
}

/// "x, y, z"; of many names the first ones.
std::string few_of(const std::vector<std::string>& names) {
  constexpr std::size_t most = 8;
  std::string list;
  for (std::size_t i = 0; i < names.size() && i < most; ++i) {
    list += (i > 0 ? ", " : "") + names[i].substr(0, 40);
  }
  return list +
         (names.size() > most ? " and " + std::to_string(names.size() - most) + " more" : "");
}

}  // namespace

Options make_options(const CommonArguments& common, const Options& defaults, Index sites,
                     Progress& progress) {
  Options options = common.preset.empty() ? defaults : find_preset(common.preset).options;
  options.seed = common.seed;
  options.threads = common.threads;
  if (common.max_iterations) options.max_iterations = *common.max_iterations;
  options.energy_tolerance = common.energy_tolerance;
  options.time_limit = common.time_limit;
  if (common.until) options.until = *common.until;
  options.on_iteration = [sites, &progress](const IterationRecord& record) {
    progress.show(record, sites);
    return true;
  };
  options.cancelled = watch_interrupts();
  return options;
}

Box make_box(const std::vector<double>& numbers, int dimension, const std::string& file) {
  const std::ptrdiff_t given = std::ssize(numbers);
  if (given != 2 * Eigen::Index{dimension}) {
    throw InvalidInput("--box: has " + std::to_string(given) + " numbers, but the points in " +
                       file + " have " + std::to_string(dimension) + " dimensions; " +
                       std::to_string(2 * Eigen::Index{dimension}) + " are needed");
  }
  const Eigen::Map<const Eigen::VectorXd> bounds(numbers.data(), given);
  Box box{bounds.head(dimension), bounds.tail(dimension)};
  for (int i = 0; i < dimension; ++i) {
    if (box.lower[i] < box.upper[i]) continue;
    throw InvalidInput("--box: dimension " + std::to_string(i + 1) + " goes from " +
                       text(box.lower[i]) + " to " + text(box.upper[i]) +
                       "; the upper bound must be above the lower one");
  }
  return box;
}

Box box_of(const PointsHeader& particles) {
  return {Coordinates::constant(particles.dimension, 0), Coordinates(particles.box)};
}

void tell_columns(const std::filesystem::path& path, const PointsHeader& header, bool quiet,
                  const std::string& advice) {
  const bool to_be_named = header.unknown && !header.columns.empty() && !advice.empty();
  if (quiet || (header.left_out.empty() && !header.reordered && !to_be_named)) return;
  std::string told = path.string() + ": coordinates are " + few_of(header.columns);
  if (header.reordered) told += ", in this order";
  if (!header.left_out.empty()) told += "; left out: " + few_of(header.left_out);
  tell(told + advice);
}

PointsHeader inspect_and_tell(const std::filesystem::path& path, const ReadOptions& options,
                              bool quiet) {
  PointsHeader header = inspect_points(path, options);
  tell_columns(path, header, quiet);
  return header;
}

std::string one_line(std::string message) {
  message = with_names_of_streams(std::move(message));
  std::replace_if(
      message.begin(), message.end(),
      [](char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }, '?');
  return message + "\n";
}

void tell(const std::string& message) { std::cerr << one_line(program_name() + ": " + message); }

void write_summary(const CommonArguments& common, const Summary& summary,
                   const std::optional<PutBack>& put_back, const std::optional<MassFigures>& masses,
                   const std::optional<RankFigures>& ranks) {
  if (!common.summary.empty()) {
    write_text(common.summary, summary_json(common.command, summary, put_back, masses, ranks));
  }
}

void warn(bool quiet, const std::vector<std::string>& warnings) {
  if (quiet) return;
  for (const std::string& warning : warnings) tell("warning: " + warning);
}

int finish(const CommonArguments& common, Publication& outputs, const Summary& summary,
           const std::optional<PutBack>& put_back) {
  const int status = publish(outputs);
  warn(common.quiet, summary.warnings);
  if (!common.quiet && put_back && put_back->sites > 0) {
    const bool dots = common.command == "stipple";
    const bool one = put_back->sites == 1;
    print("put back: " + std::to_string(put_back->sites) + (dots ? " dot" : " site") +
          (one ? "" : "s") + " lay where the " + (dots ? "picture is blank" : "density is 0") +
          ", now on the nearest point of " + (one ? "its cell" : "their cells") + ", up to " +
          text(put_back->farthest, 3) + " away\n");
  }
  if (!common.quiet) print(summary.brief() + "\n");
  return status;
}

}  // namespace ccvt::cli
