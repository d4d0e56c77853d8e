#include <Eigen/Core>
#include <utility>

#include "ccvt/io.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/tessellate_masses.h"

namespace ccvt::cli {

namespace {

Domain make_domain(const TessellateArguments& arguments, int dimension) {
  if (arguments.box.empty()) return {};
  Box box = make_box(arguments.box, dimension, arguments.points.string());
  return arguments.periodic ? Domain::periodic(std::move(box)) : Domain::euclidean(std::move(box));
}

template <class Scalar>
int tessellate_file(const TessellateArguments& arguments, const PointsHeader& header) {
  check_memory(arguments.points.string(), header.count, header.dimension, sizeof(Scalar));
  Domain domain = make_domain(arguments, header.dimension);
  Points<Scalar> initial_sites;
  Index sites = arguments.sites;
  if (!arguments.initial_sites.empty()) {
    initial_sites = read_points<Scalar>(arguments.initial_sites);
    if (initial_sites.rows() != header.dimension) {
      throw InvalidInput(arguments.initial_sites.string() + ": initial sites have " +
                         std::to_string(initial_sites.rows()) + " coordinates, points have " +
                         std::to_string(header.dimension) + ": the two must be equal");
    }
    sites = static_cast<Index>(initial_sites.cols());
  }
  const Points<Scalar> points = read_points<Scalar>(arguments.points, arguments.reading);

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
  const auto result = [&] {
    Progress progress(arguments.quiet);
    return tessellate(problem, make_options(arguments, {}, sites, progress));
  }();

  Publication outputs;
  if (!arguments.owners_out.empty()) write_owners(arguments.owners_out, result.owners);
  write_summary(arguments, result.summary);
  write_points(arguments.output, result.sites);
  return finish(arguments, outputs, result.summary);
}

}  // namespace

int run_tessellate(const TessellateArguments& arguments) {
  if (arguments.sites == 0 && arguments.initial_sites.empty()) {
    throw InvalidInput("tessellate: needs --sites or --initial-sites; see ccvt tessellate --help");
  }
  if (arguments.periodic && arguments.box.empty()) {
    throw InvalidInput(
        "--periodic: needs --box, the bounds of one period; see ccvt tessellate --help");
  }
  const PointsHeader header =
      inspect_and_tell(arguments.points, arguments.reading, arguments.quiet);
  Outputs()
      .add("--output", arguments.output, io::kTableFiles)
      .add("--owners-out", arguments.owners_out, io::kTableFiles)
      .add("--summary", arguments.summary)
      .add_input("POINTS", arguments.points)
      .add_input("--initial-sites", arguments.initial_sites)
      .add_input("--capacities", arguments.capacities)
      .add_input("--masses", arguments.mass.file)
      .check();
  if (check_masses(arguments, header)) {
    return run_with_masses(arguments, header, make_domain(arguments, header.dimension));
  }
  return arguments.scalar.value_or(header.scalar) == ScalarType::float32
             ? tessellate_file<float>(arguments, header)
             : tessellate_file<double>(arguments, header);
}

}  // namespace ccvt::cli
