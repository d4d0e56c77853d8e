#include "cli/tessellate_masses.h"

#include <algorithm>
#include <string>
#include <vector>

#include "ccvt/weighted.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/signals.h"
#include "cli/streams.h"

namespace ccvt::cli {
namespace {

/// All columns of the points' file are coordinates unless somebody says which are.
void check_column(const TessellateArguments& arguments, const PointsHeader& header) {
  const std::string& column = arguments.mass.column;
  const auto& wanted = arguments.reading.columns;
  const bool among_names =
      std::find(header.columns.begin(), header.columns.end(), column) != header.columns.end();
  const bool all = wanted.empty() && header.left_out.empty();
  if (!all && !among_names && std::find(wanted.begin(), wanted.end(), column) == wanted.end()) {
    return;
  }
  throw InvalidInput("--mass-column: '" + column + "' is among the coordinates of " +
                     arguments.points.string() + "; --columns says which columns these are");
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

template <class Scalar>
int tessellate_weighted(const TessellateArguments& arguments, const PointsHeader& header,
                        const Domain& domain) {
  MassOptions options;
  options.method = arguments.mass.method.value_or(MassMethod::whole);
  options.points_per_site = arguments.mass.points_per_site.value_or(options.points_per_site);
  options.domain = domain;
  check_memory(arguments.points.string(), header.count, header.dimension, sizeof(Scalar));
  check_memory(arguments.sites, options.points_per_site, header.dimension, sizeof(Scalar));
  const Points<Scalar> points = read_points<Scalar>(arguments.points, arguments.reading);
  const std::vector<double> masses = read_masses(arguments);
  if (!arguments.capacities.empty()) options.capacities = read_numbers(arguments.capacities);
  const auto result = [&] {
    Progress progress(arguments.quiet);
    options.relaxation = make_options(arguments, {}, arguments.sites, progress);
    return blame_file_of(
        arguments, [&] { return tessellate_masses(points, masses, arguments.sites, options); });
  }();

  Publication outputs;
  if (!arguments.owners_out.empty()) write_owners(arguments.owners_out, result.owners);
  write_summary(arguments, result.summary, {}, figures_of(result, options.method));
  write_points(arguments.output, result.sites);
  publish(outputs);
  warn(arguments.quiet, result.summary.warnings);
  if (!arguments.quiet) print(result.summary.brief() + "; " + result.brief_error() + "\n");
  return interrupted() ? 130 : 0;
}

}  // namespace

bool check_masses(const TessellateArguments& arguments, const PointsHeader& header) {
  const MassArguments& mass = arguments.mass;
  if (!mass.given()) {
    if (mass.method) throw InvalidInput("--mass-method: needs --masses or --mass-column");
    if (mass.points_per_site) {
      throw InvalidInput("--points-per-site: needs --masses or --mass-column");
    }
    return false;
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
  if (!mass.column.empty()) check_column(arguments, header);
  return true;
}

int run_with_masses(const TessellateArguments& arguments, const PointsHeader& header,
                    const Domain& domain) {
  return arguments.scalar.value_or(header.scalar) == ScalarType::float32
             ? tessellate_weighted<float>(arguments, header, domain)
             : tessellate_weighted<double>(arguments, header, domain);
}

}  // namespace ccvt::cli
