
#include "ccvt/io.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"

namespace ccvt::cli {

namespace {

template <class Scalar>
int sample(const SampleArguments& arguments) {
  check_memory(arguments.sites, arguments.points_per_site, arguments.dimension, sizeof(Scalar));
  const Index count = arguments.sites * arguments.points_per_site;
  const Box box = Box::unit(arguments.dimension);
  const Points<Scalar> points =
      sample_uniform<Scalar>(box, count, arguments.seed, arguments.distribution, arguments.threads);

  Problem<Scalar> problem(points, arguments.sites, arguments.threads);
  problem.set_domain(arguments.periodic ? Domain::periodic(box) : Domain::euclidean(box));
  if (!arguments.fixed_sites.empty()) {
    const auto fixed =
        read_sites<Scalar>(arguments.fixed_sites, "fixed sites", arguments.dimension);
    blame(arguments.fixed_sites, [&] { problem.set_fixed_sites(fixed); });
  }
  const auto result = [&] {
    Progress progress(arguments.quiet);
    return tessellate(problem,
                      make_options(arguments, Options::samples(), arguments.sites, progress));
  }();

  Publication outputs;
  if (!arguments.points_out.empty()) write_points(arguments.points_out, points);
  if (!arguments.owners_out.empty()) write_owners(arguments.owners_out, result.owners);
  write_summary(arguments, result.summary);
  write_points(arguments.output, result.sites);
  return finish(arguments, outputs, result.summary);
}

}  // namespace

int run_sample(const SampleArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kTableFiles)
      .add("--points-out", arguments.points_out, io::kTableFiles)
      .add("--owners-out", arguments.owners_out, io::kTableFiles)
      .add("--summary", arguments.summary)
      .add_input("--fixed-sites", arguments.fixed_sites)
      .check();
  return arguments.scalar == ScalarType::float64 ? sample<double>(arguments)
                                                 : sample<float>(arguments);
}

}  // namespace ccvt::cli
