#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <iostream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/metrics.h"
#include "ccvt/version.h"
#include "cli/analysis_files.h"
#include "cli/arguments.h"
#include "cli/chart.h"
#include "cli/memory.h"
#include "cli/report.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/values.h"

namespace ccvt::cli {

namespace {

namespace fs = std::filesystem;

/// Throws unless the directory is there and can be written, or can be made: which is tried.
void check_directory(const fs::path& path) {
  const auto fail = [&](const std::string& reason) {
    throw IoError(path.string() + ": cannot be written: " + reason);
  };
  std::error_code error;
  if (fs::exists(path, error)) {
    if (!fs::is_directory(path, error)) fail("is no directory");
    if (::access(path.c_str(), W_OK | X_OK) != 0) fail(std::generic_category().message(errno));
    return;
  }
  if (!fs::create_directory(path, error)) fail(error.message());
  fs::remove(path, error);
}

/// Says what to do when points are outside the unit box, and nobody asked for it.
void check_unit_box(const fs::path& path, const Points<double>& points) {
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    for (Eigen::Index d = 0; d < points.rows(); ++d) {
      if (points(d, p) >= 0 && points(d, p) <= 1) continue;
      throw InvalidInput(path.string() + ": coordinate " + std::to_string(d) + " of point " +
                         std::to_string(p) + " is " + to_text(points(d, p)) +
                         ", outside the unit box; say which box the points fill: --box LO.. HI..");
    }
  }
}

/// Of what can be read, the report only writes radial.csv, radial_2.csv and so on.
void check_not_overwritten(const fs::path& input, const fs::path& directory) {
  if (input.extension() != ".csv" || input.filename().string().rfind("radial", 0) != 0) return;
  std::error_code error;
  const fs::path parent = fs::absolute(input, error).parent_path();
  if (fs::weakly_canonical(parent, error) !=
      fs::weakly_canonical(fs::absolute(directory, error), error)) {
    return;
  }
  throw InvalidInput(input.string() + ": would be written over by the report in '" +
                     directory.string() + "'; choose another directory");
}

AnalyzedSet read_set(const AnalyzeArguments& arguments, const PointFiles& given, int dimension) {
  AnalyzedSet set;
  set.name = given.name;
  // The unit box is what `ccvt sample` fills.
  const Box box = arguments.box.empty() ? Box::unit(dimension)
                                        : make_box(arguments.box, dimension,
                                                   arguments.sets.front().files.front().string());
  for (const fs::path& path : given.files) {
    stop_if_interrupted();
    check_not_overwritten(path, arguments.output);
    const PointsHeader header = inspect_and_tell(path, arguments.reading, arguments.quiet);
    check_memory(path.string(), header.count, static_cast<std::uint64_t>(header.dimension),
                 sizeof(double));
    Points<double> points = read_points<double>(path, arguments.reading);
    if (points.rows() != dimension) {
      throw InvalidInput(path.string() + ": points have " + std::to_string(points.rows()) +
                         " coordinates, those in " + arguments.sets.front().files.front().string() +
                         " have " + std::to_string(dimension) + "; all must agree");
    }
    if (!set.runs.empty() && points.cols() != set.runs.front().count()) {
      throw InvalidInput(path.string() + ": has " + std::to_string(points.cols()) + " points, " +
                         given.files.front().string() + " has " +
                         std::to_string(set.runs.front().count()) +
                         "; files that are averaged must agree");
    }
    if (arguments.box.empty()) check_unit_box(path, points);
    set.files.push_back(path.string());
    blame(path, [&] {
      set.runs.emplace_back(std::move(points),
                            arguments.periodic ? Domain::periodic(box) : Domain::euclidean(box));
    });
  }
  return set;
}

/// The metrics of the first set, and below "compare" those of the others.
std::string metrics_json(const std::vector<AnalyzedSet>& sets) {
  nlohmann::ordered_json json;
  json["version"] = CCVT_VERSION;
  json["command"] = "analyze";
  json.update(metrics_of(sets.front()));
  for (std::size_t s = 1; s < sets.size(); ++s) {
    json["compare"][sets[s].name] = metrics_of(sets[s]);
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

/// Writes one file after the other, each of which is removed when the program is stopped in it.
class Directory {
 public:
  explicit Directory(fs::path path) : path_(std::move(path)) {
    std::error_code error;
    fs::create_directory(path_, error);
    if (error) throw IoError(path_.string() + ": cannot be made: " + error.message());
  }

  fs::path next(const std::string& name) {
    stop_if_interrupted();
    fs::path file = path_ / name;
    protect_outputs({file});
    return file;
  }

 private:
  fs::path path_;
};

std::string contents_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file || bytes.empty()) throw IoError(path.string() + ": cannot be read");
  return bytes;
}

void write_all(const AnalyzeArguments& arguments, const std::vector<AnalyzedSet>& sets) {
  Directory directory(arguments.output);
  std::vector<std::string> spectra;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const std::string suffix = s == 0 ? "" : "_" + std::to_string(s + 1);
    const fs::path picture = directory.next("spectrum" + suffix + ".png");
    write_png(picture, spectrum_image(sets[s], arguments.threads));
    spectra.push_back(contents_of(picture));
    write_text(directory.next("points" + suffix + ".svg"), svg_file(points_svg(sets[s])));
    write_text(directory.next("radial" + suffix + ".csv"), radial_csv(sets[s].analysis));
  }
  write_text(directory.next("radial.svg"), svg_file(radial_svg(sets)));
  write_text(directory.next("anisotropy.svg"), svg_file(anisotropy_svg(sets)));
  write_text(directory.next("pair_correlation.svg"), svg_file(pair_correlation_svg(sets)));
  write_text(directory.next("report.html"), report_page(sets, spectra));
  write_text(directory.next("metrics.json"), metrics_json(sets));
}

}  // namespace

int run_analyze(const AnalyzeArguments& arguments) {
  if (arguments.sets.empty()) {
    throw InvalidInput("analyze: needs POINTS or --compare; see ccvt analyze --help");
  }
  check_directory(arguments.output);
  const int dimension =
      inspect_points(arguments.sets.front().files.front(), arguments.reading).dimension;
  std::vector<AnalyzedSet> sets;
  for (const PointFiles& given : arguments.sets) {
    sets.push_back(read_set(arguments, given, dimension));
  }
  SpectrumOptions options;
  options.max_frequency = arguments.max_frequency;
  options.seed = arguments.seed;
  options.threads = arguments.threads;
  options.cancelled = [] { return interrupted(); };
  try {
    for (AnalyzedSet& set : sets) set.analysis = analyze(set.runs, options);
  } catch (const Cancelled&) {
    throw Interrupted();
  }
  write_all(arguments, sets);
  if (!arguments.quiet) {
    std::cout << report_table(sets) << std::flush;
    if (!std::cout) throw IoError("standard output: cannot be written");
  }
  return 0;
}

}  // namespace ccvt::cli
