#include "cli/tessellate_masses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "ccvt/weighted.h"
#include "cli/kept_run.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/streams.h"
#include "io/formats.h"
#include "number_text.h"

namespace ccvt::cli {
namespace {

/// Of their columns all are coordinates, unless a header names x, y, z or x0, x1, ….
constexpr std::array<std::string_view, 5> kTables = {".npy", ".csv", ".txt", ".fvecs", ".bvecs"};

/// Whether the header of the file names coordinates as such, as those of PLY files do.
bool names_coordinates(const PointsHeader& header) {
  if (header.columns.empty()) return false;
  const std::string& first = header.columns.front();
  return first == "x" || first == "X" || first == "x0" || first == "X0";
}

bool is_among(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// What the file calls the column, which may be given by its number; the number where columns have
/// no names. Throws for what is not there.
std::string name_of(const std::string& column, const std::filesystem::path& path,
                    const PointsHeader& header) {
  if (is_among(header.columns, column) || is_among(header.left_out, column)) return column;
  const PointsHeader alone = inspect_points(path, {.columns = {column}});
  return alone.columns.empty() ? column : alone.columns.front();
}

/// All columns of a file of which all are taken, by name, or by number from 1, but for one that
/// name_of() has named.
std::vector<std::string> all_but(const std::string& column, const PointsHeader& header) {
  std::vector<std::string> others = header.columns;
  if (others.empty()) {
    for (int d = 1; d <= header.dimension; ++d) others.push_back(std::to_string(d));
  }
  const auto found = header.columns.empty() ? others.begin() + std::stoi(column) - 1
                                            : std::find(others.begin(), others.end(), column);
  others.erase(found);
  return others;
}

[[noreturn]] void refuse_coordinate(const TessellateArguments& arguments) {
  throw InvalidInput("--mass-column: '" + arguments.mass.column + "' is among the coordinates of " +
                     arguments.points.string() + "; --columns says which columns these are");
}

/// Nobody said which columns of `points` are coordinates: those that the file names as such, or, of
/// a table, all but that of the masses.
PointsToRead without_masses(const TessellateArguments& arguments, PointsToRead points) {
  PointsHeader& header = points.header;
  const std::string column = name_of(arguments.mass.column, arguments.points, header);
  if (names_coordinates(header)) {
    if (is_among(header.columns, column)) refuse_coordinate(arguments);
    std::erase(header.left_out, column);
    return points;
  }
  if (!io::is_among(kTables, io::extension_of(arguments.points))) refuse_coordinate(arguments);
  points.reading.columns = all_but(column, header);
  if (points.reading.columns.empty()) {
    throw InvalidInput("--mass-column: " + arguments.points.string() + " has no column but '" +
                       column + "', and so no coordinates");
  }
  header.dimension = static_cast<int>(points.reading.columns.size());
  if (!header.columns.empty()) header.columns = points.reading.columns;
  return points;
}

std::vector<double> read_masses(const TessellateArguments& arguments) {
  if (!arguments.mass.file.empty()) return read_numbers(arguments.mass.file);
  const Points<double> column =
      read_points<double>(arguments.points, {.columns = {arguments.mass.column}});
  return {column.data(), column.data() + column.size()};
}

template <class Scalar>
MassFigures figures_of(const MassResult<Scalar>& result, MassMethod method) {
  return {to_string(method),   result.total_mass,       result.largest_mass_error,
          result.worst_site,   result.mass_error_bound, result.relative_mass_error,
          result.shared_points};
}

/// What is wrong is in the file of the argument that the message starts with.
template <class Work>
decltype(auto) blame_file_of(const TessellateArguments& arguments, const Work& work) {
  try {
    return work();
  } catch (const InvalidInput& error) {
    const std::string message = error.what();
    const auto starts = [&](const char* name) { return message.rfind(name, 0) == 0; };
    const auto& masses = arguments.mass.file.empty() ? arguments.points : arguments.mass.file;
    if (starts("masses")) throw InvalidInput(masses.string() + ": " + message);
    if (starts("capacities")) throw InvalidInput(arguments.capacities.string() + ": " + message);
    if (starts("points") || starts("domain")) {
      throw InvalidInput(arguments.points.string() + ": " + message);
    }
    throw;
  }
}

/// The largest difference of a cell's mass from its capacity, as a share of that, when each point
/// is given whole to its owner.
template <class Scalar>
double error_of_owners(const MassResult<Scalar>& result, const std::vector<double>& masses) {
  std::vector<double> cells(result.capacities.size(), 0.0);
  for (std::size_t p = 0; p < masses.size(); ++p) {
    cells[static_cast<std::size_t>(result.owners[p])] += masses[p];
  }
  double largest = 0;
  for (std::size_t s = 0; s < cells.size(); ++s) {
    largest = std::max(largest, std::abs(cells[s] / result.capacities[s] - 1));
  }
  return largest;
}

/// A row a share: the point, the site, and what that owns of the point's mass.
Points<double> table_of(const std::vector<MassShare>& shares) {
  Points<double> table(3, std::ssize(shares));
  for (std::size_t k = 0; k < shares.size(); ++k) {
    const MassShare& share = shares[k];
    table.col(static_cast<Eigen::Index>(k)) << share.point, share.site, share.mass;
  }
  return table;
}

template <class Scalar>
int tessellate_weighted(const TessellateArguments& arguments, const PointsHeader& header,
                        const Domain& domain) {
  MassOptions options;
  options.method = arguments.mass.method.value_or(MassMethod::whole);
  options.points_per_site = arguments.mass.points_per_site.value_or(options.points_per_site);
  options.domain = domain;
  check_memory(arguments.points.string(), header.count, header.dimension, sizeof(Scalar));
  check_memory(arguments.sites, options.points_per_site, header.dimension, sizeof(Scalar));
  const KeptRun kept(arguments);
  const Points<Scalar> points = read_points<Scalar>(arguments.points, arguments.reading);
  const std::vector<double> masses = read_masses(arguments);
  if (!arguments.capacities.empty()) options.capacities = read_numbers(arguments.capacities);
  const auto result = [&] {
    Progress progress(arguments.quiet, arguments.time_limit);
    options.relaxation =
        kept.options(make_options(arguments, {}, arguments.sites, progress), progress);
    return blame_file_of(
        arguments, [&] { return tessellate_masses(points, masses, arguments.sites, options); });
  }();

  Publication outputs;
  if (!arguments.owners_out.empty()) write_owners(arguments.owners_out, result.owners);
  if (!arguments.mass.shares_out.empty()) {
    write_points(arguments.mass.shares_out, table_of(result.shares));
  }
  write_summary(arguments, result.summary, {}, figures_of(result, options.method));
  write_points(arguments.output, result.sites);
  const int status = publish(outputs);
  kept.end(result.summary);
  warn(arguments.quiet, result.summary.warnings);
  if (arguments.quiet) return status;
  print(result.summary.brief() + "; " + result.brief_error() + "\n");
  if (options.method == MassMethod::resampled) {
    print(std::to_string(result.shared_points) +
          " points are shared by sites; given whole to their owners, they make masses miss "
          "capacities by up to " +
          text(100 * error_of_owners(result, masses), 3) + " %\n");
  }
  return status;
}

}  // namespace

bool check_masses(const TessellateArguments& arguments) {
  const MassArguments& mass = arguments.mass;
  if (!mass.given()) {
    if (mass.method) throw InvalidInput("--mass-method: needs --masses or --mass-column");
    if (mass.points_per_site) {
      throw InvalidInput("--points-per-site: needs --masses or --mass-column");
    }
    if (!mass.shares_out.empty()) {
      throw InvalidInput("--shares-out: needs --masses or --mass-column");
    }
    return false;
  }
  if (!mass.shares_out.empty() && mass.method != MassMethod::resampled) {
    throw InvalidInput("--shares-out: needs --mass-method resampled, which shares points");
  }
  if (!arguments.initial_sites.empty()) {
    throw InvalidInput("--initial-sites: is for points without masses; --sites says how many");
  }
  const char* const alone = !arguments.fixed_sites.empty() ? "--fixed-sites"
                            : !arguments.units.empty()     ? "--units"
                            : arguments.whiten             ? "--whiten"
                                                           : nullptr;
  if (alone != nullptr) {
    throw InvalidInput(std::string(alone) + ": cannot be combined with masses");
  }
  return true;
}

PointsToRead inspect_beside_masses(const TessellateArguments& arguments) {
  PointsToRead points{arguments.reading, {}};
  const std::string& column = arguments.mass.column;
  if (column.empty() || arguments.reading.columns.empty()) {
    points.header = inspect_points(arguments.points, arguments.reading);
    return column.empty() ? points : without_masses(arguments, std::move(points));
  }
  std::vector<std::string> all = arguments.reading.columns;
  if (std::find(all.begin(), all.end(), column) != all.end()) refuse_coordinate(arguments);
  all.push_back(column);
  points.header = inspect_points(arguments.points, {.columns = std::move(all)});
  --points.header.dimension;
  if (!points.header.columns.empty()) points.header.columns.pop_back();
  return points;
}

int run_with_masses(const TessellateArguments& arguments, const PointsHeader& header,
                    const Domain& domain) {
  return arguments.scalar.value_or(header.scalar) == ScalarType::float32
             ? tessellate_weighted<float>(arguments, header, domain)
             : tessellate_weighted<double>(arguments, header, domain);
}

}  // namespace ccvt::cli
