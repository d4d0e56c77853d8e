#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/metrics.h"
#include "ccvt/publication.h"
#include "ccvt/version.h"
#include "cli/analysis_files.h"
#include "cli/arguments.h"
#include "cli/chart.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/report.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/standard_streams.h"
#include "cli/streams.h"
#include "cli/values.h"
#include "precision.h"

namespace ccvt::cli {

namespace {

namespace fs = std::filesystem;

/// The directory of the report. Made if it is not there; then, unless it is kept, removed again.
class Directory {
 public:
  explicit Directory(fs::path path) : path_(std::move(path)) { make(); }
  Directory(const Directory&) = delete;
  Directory& operator=(const Directory&) = delete;
  ~Directory() {
    remove_at_end("");
    if (made_) ::rmdir(path_.c_str());
  }

  /// Another program may make or remove it at any time: what is there is used. Throws IoError.
  void make() {
    if (::mkdir(path_.c_str(), 0777) == 0) {
      made_ = true;
      remove_at_end(path_);
      return;
    }
    const int why = errno;
    std::error_code error;
    if (fs::is_directory(path_, error)) return;
    const std::string reason =
        why == EEXIST ? "is no directory" : std::generic_category().message(why);
    throw IoError(path_.string() + ": cannot be written: " + reason);
  }
  void keep() {
    made_ = false;
    remove_at_end("");
  }
  [[nodiscard]] fs::path operator/(const std::string& name) const { return path_ / name; }

 private:
  fs::path path_;
  bool made_ = false;
};

/// What is written for the set of this number, from 0.
fs::path file_of_set(const Directory& directory, const std::string& name,
                     const std::string& extension, std::size_t set) {
  return directory / (name + (set == 0 ? "" : "_" + std::to_string(set + 1)) + extension);
}

/// All that write_all() writes.
std::vector<fs::path> files_of_report(const Directory& directory, std::size_t sets) {
  std::vector<fs::path> files;
  for (std::size_t s = 0; s < sets; ++s) {
    files.push_back(file_of_set(directory, "spectrum", ".png", s));
    files.push_back(file_of_set(directory, "points", ".svg", s));
    files.push_back(file_of_set(directory, "radial", ".csv", s));
    files.push_back(file_of_set(directory, "low_frequency", ".csv", s));
  }
  for (const char* const name : {"radial.svg", "power_law.svg", "anisotropy.svg",
                                 "pair_correlation.svg", "metrics.json", "report.html"}) {
    files.push_back(directory / name);
  }
  return files;
}

/// Throws when the report would replace what it is about, or cannot be written.
void check_report(const AnalyzeArguments& arguments, const Directory& directory) {
  Outputs outputs;
  for (const fs::path& file : files_of_report(directory, arguments.sets.size())) {
    outputs.add(file.filename().string(), file);
    for (const PointFiles& given : arguments.sets) {
      for (const fs::path& input : given.files) {
        std::error_code error;
        if (!fs::equivalent(input, file, error)) continue;
        throw InvalidInput(input.string() + ": would be written over by the report in '" +
                           arguments.output.string() + "'; choose another directory");
      }
    }
  }
  outputs.check();
}

/// Says what to do when points are outside the unit box, and nobody asked for it.
void check_unit_box(const fs::path& path, const Points<double>& points) {
  for (Eigen::Index p = 0; p < points.cols(); ++p) {
    for (Eigen::Index d = 0; d < points.rows(); ++d) {
      if (points(d, p) >= 0 && points(d, p) <= 1) continue;
      throw InvalidInput(path.string() + ": coordinate " + std::to_string(d) + " of point " +
                         std::to_string(p) + " is " + concat(points(d, p)) +
                         ", outside the unit box; say which box the points fill: --box LO.. HI..");
    }
  }
}

/// The box that points fill: what the user says, or their file, or the unit box, which is what
/// `ccvt sample` fills. A box that only the file tells is periodic.
Domain domain_of(const AnalyzeArguments& arguments, const PointsHeader& header) {
  if (arguments.box.empty() && !header.box.empty()) {
    return Domain::periodic(box_of(header));
  }
  const Box box = arguments.box.empty() ? Box::unit(header.dimension)
                                        : make_box(arguments.box, header.dimension,
                                                   arguments.sets.front().files.front().string());
  return arguments.periodic ? Domain::periodic(box) : Domain::euclidean(box);
}

/// The box of the last run read is that of the first.
void check_same_box(const AnalyzedSet& set, const fs::path& path) {
  const Domain& first = set.runs.front().domain();
  const Domain& last = set.runs.back().domain();
  if (first.box().upper == last.box().upper && first.is_periodic() == last.is_periodic()) return;
  throw InvalidInput(path.string() + ": fills another box than " + set.files.front() +
                     "; files that are averaged must agree");
}

AnalyzedSet read_set(const AnalyzeArguments& arguments, const PointFiles& given, int dimension) {
  AnalyzedSet set;
  set.name = given.name;
  for (const fs::path& path : given.files) {
    const PointsHeader header = inspect_and_tell(path, arguments.reading, arguments.quiet);
    check_memory(path.string(), header.count, header.dimension, sizeof(double));
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
    const Domain domain = domain_of(arguments, header);
    if (arguments.box.empty() && header.box.empty()) check_unit_box(path, points);
    if (header.scalar == ScalarType::float32) {
      const std::string warning = coarse_coordinates<float>(
          "points", view_points(points),
          spacing_in_box(domain.box(), static_cast<Index>(points.cols())));
      if (!warning.empty()) warn(arguments.quiet, {path.string() + ": " + warning});
    }
    set.files.push_back(with_names_of_streams(path.string()));
    Columns<double> placed(points);
    if (header.scalar == ScalarType::float32) {
      placed = detail::on_faces<float>(std::move(placed), domain.box());
    }
    blame(path, [&] { set.runs.emplace_back(std::move(placed), domain); });
    check_same_box(set, path);
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

std::string contents_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(file), {}};
  if (!file || bytes.empty()) throw IoError(path.string() + ": cannot be read");
  return bytes;
}

/// All files of the report, the page that shows them last.
void write_all(const AnalyzeArguments& arguments, const Directory& directory,
               const std::vector<AnalyzedSet>& sets) {
  Publication outputs;
  std::vector<std::string> spectra;
  for (std::size_t s = 0; s < sets.size(); ++s) {
    const fs::path picture = file_of_set(directory, "spectrum", ".png", s);
    write_png(picture, spectrum_image(sets[s], arguments.threads));
    spectra.push_back(contents_of(outputs.unpublished(picture)));
    write_text(file_of_set(directory, "points", ".svg", s), svg_file(points_picture(sets[s]).svg));
    write_text(file_of_set(directory, "radial", ".csv", s), radial_csv(sets[s].analysis));
    write_text(file_of_set(directory, "low_frequency", ".csv", s),
               low_frequency_csv(sets[s].analysis));
  }
  write_text(directory / "radial.svg", svg_file(radial_svg(sets)));
  write_text(directory / "power_law.svg", svg_file(power_law_svg(sets)));
  write_text(directory / "anisotropy.svg", svg_file(anisotropy_svg(sets)));
  write_text(directory / "pair_correlation.svg", svg_file(pair_correlation_svg(sets)));
  write_text(directory / "metrics.json", metrics_json(sets));
  write_text(directory / "report.html", report_page(sets, spectra));
  publish(outputs);
}

}  // namespace

int run_analyze(const AnalyzeArguments& arguments) {
  if (arguments.sets.empty()) {
    throw InvalidInput("analyze: needs POINTS or --compare; see ccvt analyze --help");
  }
  Directory directory = check_before([&] { return Directory(arguments.output); });
  check_report(arguments, directory);
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
  // Nothing is written before the end, so Ctrl-C ends the program at once: `cancelled` has no use.
  for (AnalyzedSet& set : sets) set.analysis = analyze(set.runs, options);
  directory.make();
  write_all(arguments, directory, sets);
  directory.keep();
  if (!arguments.quiet) print(report_table(sets));
  return 0;
}

}  // namespace ccvt::cli
