#include "cli/tessellate.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/linear_map.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"
#include "cli/outputs.h"
#include "commands.h"
#include "results.h"

namespace ccvt::mpi {
namespace {

using cli::TessellateArguments;

void require_supported(const TessellateArguments& arguments) {
  require_npy("--owners-out", arguments.owners_out);
  require_parts(arguments.points);
}

/// What a rank reads: its part of the points, and all else.
template <class Scalar>
struct Inputs {
  Points<Scalar> points;
  Points<Scalar> initial_sites;
  Points<Scalar> fixed_sites;
  Points<Scalar> mapped_fixed_sites;
  std::vector<Index> capacities;
  Domain domain;
  std::optional<LinearMap> map;  ///< which all but the fixed sites have gone through
};

template <class Scalar>
Inputs<Scalar> read_inputs(const Session& session, const Session::Share& share,
                           const TessellateArguments& arguments, const PointsHeader& header) {
  const auto all = static_cast<std::int64_t>(header.count);
  session.check_memory(arguments.points.string(), share.size(), header.dimension, sizeof(Scalar),
                       all / std::max<Index>(1, arguments.sites));
  Inputs<Scalar> read;
  read.domain = cli::make_domain(arguments, header);
  read.points = read_points<Scalar>(arguments.points, share.of(arguments.reading));
  const auto sites = [&](const std::filesystem::path& file, const char* what) {
    return file.empty() ? Points<Scalar>(header.dimension, 0)
                        : cli::read_sites<Scalar>(file, what, header.dimension, arguments.quiet);
  };
  read.initial_sites = sites(arguments.initial_sites, "initial sites");
  read.fixed_sites = sites(arguments.fixed_sites, "fixed sites");
  if (!arguments.capacities.empty()) read.capacities = read_indices(arguments.capacities);
  return read;
}

/// How distances are measured, if not as the coordinates say.
template <class Scalar>
std::optional<LinearMap> make_map(const Session& session, const TessellateArguments& arguments,
                                  const Points<Scalar>& points) {
  if (!arguments.whiten) return cli::units_of(arguments, static_cast<int>(points.rows()));
  return cli::blame(arguments.points,
                    [&] { return LinearMap::whitening(session.ranks(), points); });
}

template <class Scalar>
void map_inputs(const TessellateArguments& arguments, Inputs<Scalar>& read) {
  read.mapped_fixed_sites = read.fixed_sites;
  if (!read.map) return;
  read.domain = read.map->template domain_of<Scalar>(read.domain);
  cli::blame(arguments.points, [&] { read.points = (*read.map)(read.points); });
  read.initial_sites = (*read.map)(read.initial_sites);
  read.mapped_fixed_sites = (*read.map)(read.fixed_sites);
}

template <class Scalar>
Problem<Scalar> make_problem(const Session& session, const TessellateArguments& arguments,
                             Index sites, const Inputs<Scalar>& read) {
  Problem<Scalar> problem = cli::blame(arguments.points, [&] {
    return Problem<Scalar>(session.ranks(), view_points(read.points), sites, arguments.threads);
  });
  cli::blame(arguments.points, [&] { problem.set_domain(read.domain); });
  if (!read.capacities.empty()) {
    cli::blame(arguments.capacities, [&] { problem.set_capacities(read.capacities); });
  }
  if (read.initial_sites.size() > 0) {
    cli::blame(arguments.initial_sites, [&] { problem.set_initial_sites(read.initial_sites); });
  }
  if (read.fixed_sites.size() > 0) {
    cli::blame(arguments.fixed_sites, [&] { problem.set_fixed_sites(read.mapped_fixed_sites); });
  }
  return problem;
}

template <class Scalar>
int tessellate_file(const Session& session, const TessellateArguments& arguments,
                    const PointsHeader& header) {
  const Kept kept(session, arguments);
  const Session::Share share = session.share(static_cast<std::int64_t>(header.count));
  Inputs<Scalar> read;
  session.together([&] { read = read_inputs<Scalar>(session, share, arguments, header); });
  read.map = make_map(session, arguments, read.points);
  session.together([&] { map_inputs(arguments, read); });
  const Index sites = arguments.initial_sites.empty()
                          ? arguments.sites
                          : static_cast<Index>(read.initial_sites.cols());
  const Problem<Scalar> problem = make_problem(session, arguments, sites, read);
  auto result =
      kept.solve({}, sites, [&](const Options& options) { return tessellate(problem, options); });
  if (read.map) {
    result.sites =
        cli::mapped_back(*read.map, result.sites, read.fixed_sites, read.mapped_fixed_sites);
  }
  OwnersFile owners(session, arguments.owners_out, static_cast<std::int64_t>(header.count));
  owners.write(share.begin, result.owners);
  return finish(session, arguments, kept, result.summary, [&] {
    owners.publish();
    write_points(arguments.output, result.sites);
  });
}

}  // namespace

int run_tessellate(const Session& session, const TessellateArguments& given) {
  TessellateArguments arguments = session.own(given);
  PointsHeader header;
  session.together([&] {
    cli::check_arguments(arguments);
    require_supported(arguments);
    if (session.is_first()) cli::check_outputs(arguments);
    arguments.sites = cli::number_of_sites(arguments);
    header = cli::inspect_and_tell(arguments.points, arguments.reading, arguments.quiet);
    require_balanced(arguments, arguments.points.string(), header.dimension);
  });
  require_one_file(session, arguments.points, header);
  return arguments.scalar.value_or(header.scalar) == ScalarType::float32
             ? tessellate_file<float>(session, arguments, header)
             : tessellate_file<double>(session, arguments, header);
}

}  // namespace ccvt::mpi
