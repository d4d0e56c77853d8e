#include "ccvt/thin.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "ccvt/point_cloud.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/streams.h"
#include "cli/thin_arguments.h"
#include "io/formats.h"
#include "number_text.h"

namespace ccvt::cli {

namespace {

/// Coordinates of lifted points, home by home, and what is known of each point, in bytes.
constexpr std::uint64_t kOtherBytes = 48;

Index sites_of(const ThinArguments& arguments, std::ptrdiff_t points) {
  if (arguments.sites > 0) return arguments.sites;
  const double sites = std::round(static_cast<double>(points) / arguments.ratio);
  return static_cast<Index>(std::max(sites, 1.0));
}

/// Files of one kind carry all that is known of points from one to the other.
std::string kind_of(const std::filesystem::path& path) {
  const std::string extension = io::extension_of(path);
  return extension == ".txt" ? ".csv" : extension;
}

/// What of the file does not come along, and what of it is not known.
void tell_of_losses(const ThinArguments& arguments, const PointCloud& cloud) {
  if (arguments.quiet) return;
  const std::string file = arguments.points.string() + ": ";
  std::string elements;
  for (const std::string& name : cloud.dropped) {
    elements += (elements.empty() ? "'" : ", '") + name.substr(0, 40) + "'";
  }
  if (!elements.empty()) {
    tell(file + "only vertices are thinned; dropped: " + elements);
  }
  const bool has_more = !cloud.kept.empty() || cloud.normals.cols() > 0;
  if (has_more && kind_of(arguments.points) != kind_of(arguments.output)) {
    tell(
        file +
        "what its points carry besides coordinates is kept in files of its own kind only, not in " +
        io::extension_of(arguments.output));
  }
  if (cloud.unknown_normals > 0) {
    tell(concat(file, cloud.unknown_normals, " normals are not finite; nothing is known of these"));
  }
}

template <class Scalar>
Thinning thin_cloud(const ThinArguments& arguments, const PointCloud& cloud, Index sites) {
  const Points<Scalar> points = cloud.points.eigen().template cast<Scalar>();
  const Points<Scalar> normals = cloud.normals.eigen().template cast<Scalar>();
  ThinOptions options;
  options.normal_weight = arguments.normal_weight.value_or(options.normal_weight);
  options.equal_counts = arguments.equal_counts;
  return blame(arguments.points, [&] {
    Progress progress(arguments.quiet, arguments.time_limit);
    options.tessellation = make_options(arguments, options.tessellation, sites, progress);
    return thin(view_points(points), sites, options,
                normals.size() > 0 ? view_points(normals) : PointsView<Scalar>());
  });
}

/// In a table of text without a header the column that is added has no name either.
void tell_of_counts(const ThinArguments& arguments, const PointsHeader& header) {
  if (arguments.quiet || !header.columns.empty()) return;
  if (kind_of(arguments.points) != ".csv" || kind_of(arguments.output) != ".csv") return;
  tell("the last column written says how many points each one stands for; it is no coordinate");
}

/// Points that count for another than they would without normals.
std::string turned_text(const Thinning& result, bool equal_counts) {
  if (result.turned == 0) return "";
  return concat(
      "; ", result.turned,
      equal_counts ? " had no room on their own side" : " have a nearer one that faces away");
}

std::string closing_line(const Thinning& result, bool equal_counts) {
  const auto points = static_cast<double>(result.owners.size());
  const auto [least, most] = std::minmax_element(result.counts.begin(), result.counts.end());
  return concat("chosen: ", result.chosen.size(), " points that stand for ", *least,
                *least == *most ? std::string() : concat(" to ", *most), " each, at ",
                text(std::sqrt(result.energy / points), 3), " from these (root mean square); ",
                result.moves + result.jumps, " moves apart", turned_text(result, equal_counts),
                "\n");
}

}  // namespace

int run_thin(const ThinArguments& arguments) {
  if (arguments.sites == 0 && arguments.ratio == 0) {
    throw InvalidInput("thin: needs --sites or --ratio; see ccvt thin --help");
  }
  Outputs()
      .add("--output", arguments.output, io::kThinFiles)
      .add("--indices-out", arguments.indices_out, io::kTableFiles)
      .add("--owners-out", arguments.owners_out, io::kTableFiles)
      .add("--summary", arguments.summary)
      .add_input("POINTS", arguments.points)
      .check();
  const PointsHeader header = inspect_points(arguments.points, arguments.reading);
  check_memory(arguments.points.string(), header.count, 2 * header.dimension, sizeof(double),
               header.count * kOtherBytes + std::filesystem::file_size(arguments.points));
  const PointCloud cloud = read_point_cloud(arguments.points, arguments.reading);
  if (arguments.normal_weight.value_or(0) > 0 && cloud.normals.cols() == 0) {
    throw InvalidInput("--normal-weight: " + arguments.points.string() +
                       " has no normals nx, ny, nz that could count");
  }
  tell_of_losses(arguments, cloud);
  const Index sites = sites_of(arguments, cloud.points.cols());
  const Thinning result = arguments.scalar.value_or(cloud.scalar) == ScalarType::float32
                              ? thin_cloud<float>(arguments, cloud, sites)
                              : thin_cloud<double>(arguments, cloud, sites);
  Publication outputs;
  if (!arguments.indices_out.empty()) write_owners(arguments.indices_out, result.chosen);
  if (!arguments.owners_out.empty()) write_owners(arguments.owners_out, result.owners);
  write_summary(arguments, result.summary);
  write_point_cloud(arguments.output, cloud, result.chosen, result.counts);
  tell_of_counts(arguments, header);
  if (!arguments.quiet) print(closing_line(result, arguments.equal_counts));
  return finish(arguments, outputs, result.summary);
}

}  // namespace ccvt::cli
