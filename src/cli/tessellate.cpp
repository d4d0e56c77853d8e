#include "cli/tessellate.h"

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/linear_map.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "cli/kept_run.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/standard_streams.h"
#include "cli/tessellate_masses.h"

namespace ccvt::cli {

namespace {

/// How distances are measured, if not as the coordinates say.
template <class Scalar>
std::optional<LinearMap> make_map(const TessellateArguments& arguments,
                                  const Points<Scalar>& points) {
  if (arguments.whiten) {
    return blame(arguments.points, [&] { return LinearMap::whitening(points); });
  }
  return units_of(arguments, static_cast<int>(points.rows()));
}

bool is_periodic(const TessellateArguments& arguments) {
  return arguments.periodic || !arguments.periodic_along.empty();
}

[[noreturn]] void fail_without_box(const TessellateArguments& arguments) {
  throw InvalidInput(
      std::string(arguments.periodic_along.empty() ? "--periodic" : "--periodic-along") +
      ": needs --box, the bounds of one period; see " + program_name() + " tessellate --help");
}

template <class Scalar>
int tessellate_file(const TessellateArguments& arguments, const PointsHeader& header) {
  const KeptRun kept(arguments);
  check_memory(arguments.points.string(), header.count, header.dimension, sizeof(Scalar));
  Domain domain = make_domain(arguments, header);
  Points<Scalar> initial_sites;
  Points<Scalar> fixed_sites(header.dimension, 0);
  Points<Scalar> mapped_fixed_sites;
  Index sites = arguments.sites;
  if (!arguments.initial_sites.empty()) {
    initial_sites = read_sites<Scalar>(arguments.initial_sites, "initial sites", header.dimension,
                                       arguments.quiet);
    sites = static_cast<Index>(initial_sites.cols());
  }
  if (!arguments.fixed_sites.empty()) {
    fixed_sites =
        read_sites<Scalar>(arguments.fixed_sites, "fixed sites", header.dimension, arguments.quiet);
  }
  Points<Scalar> points = read_points<Scalar>(arguments.points, arguments.reading);
  const std::optional<LinearMap> map = make_map(arguments, points);
  if (map) {
    domain = map->template domain_of<Scalar>(domain);
    blame(arguments.points, [&] { points = (*map)(points); });
    if (initial_sites.size() > 0) initial_sites = (*map)(initial_sites);
    if (fixed_sites.size() > 0) mapped_fixed_sites = (*map)(fixed_sites);
  }

  Problem<Scalar> problem =
      blame(arguments.points, [&] { return Problem<Scalar>(points, sites, arguments.threads); });
  blame(arguments.points, [&] { problem.set_domain(std::move(domain)); });
  if (!arguments.capacities.empty()) {
    auto capacities = read_indices(arguments.capacities);
    blame(arguments.capacities, [&] { problem.set_capacities(std::move(capacities)); });
  }
  if (initial_sites.size() > 0) {
    blame(arguments.initial_sites, [&] { problem.set_initial_sites(initial_sites); });
  }
  if (fixed_sites.size() > 0) {
    blame(arguments.fixed_sites,
          [&] { problem.set_fixed_sites(map ? mapped_fixed_sites : fixed_sites); });
  }
  auto result = [&] {
    Progress progress(arguments.quiet, arguments.time_limit);
    return tessellate(problem,
                      kept.options(make_options(arguments, {}, sites, progress), progress));
  }();
  if (map) result.sites = mapped_back(*map, result.sites, fixed_sites, mapped_fixed_sites);

  Publication outputs;
  if (!arguments.owners_out.empty()) write_owners(arguments.owners_out, result.owners);
  write_summary(arguments, result.summary);
  write_points(arguments.output, result.sites);
  const int status = finish(arguments, outputs, result.summary);
  kept.end(result.summary);
  return status;
}

}  // namespace

Domain make_domain(const TessellateArguments& arguments, const PointsHeader& header) {
  const int dimension = header.dimension;
  if (arguments.box.empty() && !is_periodic(arguments)) return {};
  if (arguments.box.empty() && header.box.empty()) fail_without_box(arguments);
  Box box = arguments.box.empty() ? box_of(header)
                                  : make_box(arguments.box, dimension, arguments.points.string());
  std::vector<bool> along(static_cast<std::size_t>(dimension), arguments.periodic);
  for (const int d : arguments.periodic_along) {
    if (d > dimension) {
      throw InvalidInput("--periodic-along: there is no dimension " + std::to_string(d) +
                         ": the points have " + std::to_string(dimension));
    }
    along[static_cast<std::size_t>(d - 1)] = true;
  }
  return Domain::periodic(std::move(box), along);
}

std::optional<LinearMap> units_of(const TessellateArguments& arguments, int dimension) {
  if (arguments.units.empty()) return {};
  if (std::ssize(arguments.units) != dimension) {
    throw InvalidInput("--units: there are " + std::to_string(arguments.units.size()) +
                       " numbers, but the points in " + arguments.points.string() + " have " +
                       std::to_string(dimension) + " dimensions");
  }
  return LinearMap::units(Coordinates(arguments.units));
}

void check_arguments(const TessellateArguments& arguments) {
  if (arguments.sites == 0 && arguments.initial_sites.empty() && arguments.capacities.empty()) {
    throw InvalidInput("tessellate: needs --sites, --initial-sites or --capacities; see " +
                       program_name() + " tessellate --help");
  }
  if (arguments.whiten && !arguments.units.empty()) {
    throw InvalidInput("--whiten: excludes --units");
  }
  if (arguments.whiten && !arguments.box.empty()) {
    throw InvalidInput("--whiten: excludes --box, which it would turn");
  }
  if (arguments.whiten && is_periodic(arguments)) {
    throw InvalidInput("--whiten: excludes periodic boxes, which it would turn");
  }
  const bool may_have_box = io::is_among(io::kParticleFiles, io::extension_of(arguments.points)) &&
                            arguments.reading.columns.empty();
  if (is_periodic(arguments) && arguments.box.empty() && !may_have_box) {
    fail_without_box(arguments);
  }
}

Index number_of_sites(const TessellateArguments& arguments) {
  if (arguments.sites > 0 || !arguments.initial_sites.empty()) return arguments.sites;
  return static_cast<Index>(arguments.mass.given() ? read_numbers(arguments.capacities).size()
                                                   : read_indices(arguments.capacities).size());
}

void check_outputs(const TessellateArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kTableFiles)
      .add("--owners-out", arguments.owners_out, io::kTableFiles)
      .add("--shares-out", arguments.mass.shares_out, io::kTableFiles)
      .add("--summary", arguments.summary)
      .add_input("POINTS", arguments.points)
      .add_input("--checkpoint", checkpoint_file(arguments))
      .add_input("--initial-sites", arguments.initial_sites)
      .add_input("--fixed-sites", arguments.fixed_sites)
      .add_input("--capacities", arguments.capacities)
      .add_input("--masses", arguments.mass.file)
      .check();
}

int run_tessellate(const TessellateArguments& arguments) {
  check_arguments(arguments);
  const bool has_masses = check_masses(arguments);
  check_outputs(arguments);
  const auto [reading, header] = inspect_beside_masses(arguments);
  tell_columns(arguments.points, header, arguments.quiet);
  TessellateArguments chosen = arguments;
  chosen.reading = reading;
  chosen.sites = number_of_sites(arguments);
  if (has_masses) {
    return run_with_masses(chosen, header, make_domain(chosen, header));
  }
  return chosen.scalar.value_or(header.scalar) == ScalarType::float32
             ? tessellate_file<float>(chosen, header)
             : tessellate_file<double>(chosen, header);
}

}  // namespace ccvt::cli
