#include "cli/tessellate.h"

#include "ccvt/io.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "commands.h"
#include "results.h"

namespace ccvt::mpi {
namespace {

using cli::TessellateArguments;

void require_supported(const TessellateArguments& arguments) {
  const auto refuse = [](const std::string& option) {
    throw InvalidInput(option + ": is for ccvt only, not for several processes");
  };
  if (arguments.whiten) refuse("--whiten");
  if (!arguments.units.empty()) refuse("--units");
  if (!arguments.mass.file.empty()) refuse("--masses");
  if (!arguments.mass.column.empty()) refuse("--mass-column");
  require_npy("--owners-out", arguments.owners_out);
}

template <class Scalar>
int tessellate_file(const Session& session, const TessellateArguments& arguments,
                    const PointsHeader& header) {
  const Kept kept(session, arguments);
  const Session::Share share = session.share(static_cast<std::int64_t>(header.count));
  Points<Scalar> points;
  Points<Scalar> initial_sites;
  Points<Scalar> fixed_sites;
  std::vector<Index> capacities;
  Domain domain;
  session.together([&] {
    cli::check_memory(arguments.points.string(), static_cast<std::uint64_t>(share.size()),
                      header.dimension, sizeof(Scalar));
    domain = cli::make_domain(arguments, header.dimension);
    ReadOptions part = arguments.reading;
    part.first_row = static_cast<std::uint64_t>(share.begin);
    part.end_row = static_cast<std::uint64_t>(share.end);
    points = read_points<Scalar>(arguments.points, part);
    if (!arguments.initial_sites.empty()) {
      initial_sites =
          cli::read_sites<Scalar>(arguments.initial_sites, "initial sites", header.dimension);
    }
    if (!arguments.fixed_sites.empty()) {
      fixed_sites = cli::read_sites<Scalar>(arguments.fixed_sites, "fixed sites", header.dimension);
    }
    if (!arguments.capacities.empty()) capacities = read_indices(arguments.capacities);
  });
  const Index sites =
      initial_sites.size() > 0 ? static_cast<Index>(initial_sites.cols()) : arguments.sites;
  Problem<Scalar> problem = cli::blame(arguments.points, [&] {
    return Problem<Scalar>(session.ranks(), view_points(points), sites, arguments.threads);
  });
  cli::blame(arguments.points, [&] { problem.set_domain(std::move(domain)); });
  if (!capacities.empty()) {
    cli::blame(arguments.capacities, [&] { problem.set_capacities(std::move(capacities)); });
  }
  if (initial_sites.size() > 0) {
    cli::blame(arguments.initial_sites, [&] { problem.set_initial_sites(initial_sites); });
  }
  if (fixed_sites.size() > 0) {
    cli::blame(arguments.fixed_sites, [&] { problem.set_fixed_sites(fixed_sites); });
  }
  const auto result =
      kept.solve({}, sites, [&](const Options& options) { return tessellate(problem, options); });
  OwnersFile owners(session, arguments.owners_out, static_cast<std::int64_t>(header.count));
  owners.write(share.begin, result.owners);
  return finish(session, arguments, kept, result.summary, [&] {
    owners.publish();
    write_points(arguments.output, result.sites);
  });
}

}  // namespace

int run_tessellate(const Session& session, const TessellateArguments& given) {
  const TessellateArguments arguments = session.own(given);
  PointsHeader header;
  session.together([&] {
    cli::check_arguments(arguments);
    require_supported(arguments);
    if (session.is_first()) cli::check_outputs(arguments);
    header = cli::inspect_and_tell(arguments.points, arguments.reading, arguments.quiet);
  });
  return arguments.scalar.value_or(header.scalar) == ScalarType::float32
             ? tessellate_file<float>(session, arguments, header)
             : tessellate_file<double>(session, arguments, header);
}

}  // namespace ccvt::mpi
