#include "cli/sample.h"

#include "ccvt/io.h"
#include "ccvt/particles.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "cli/kept_run.h"
#include "cli/memory.h"
#include "cli/outputs.h"
#include "cli/run.h"
#include "cli/streams.h"
#include "number_text.h"

namespace ccvt::cli {

namespace {

/// "2097152 particles of mass 0.00411 in a box of 100"
std::string describe_particles(Index sites, const ParticleOptions& options) {
  return std::to_string(particle_count(sites, options)) + " particles of mass " +
         text(particle_mass(sites, options), 6) + " in a periodic box of " + text(options.box_size);
}

template <class Scalar>
int sample(const SampleArguments& arguments) {
  const KeptRun kept(arguments);
  const bool particles = makes_particles(arguments);
  const ParticleOptions load = particle_options(arguments.particles);
  if (particles) check_particles(arguments.output, arguments.sites, sizeof(Scalar), load);
  check_memory(arguments.sites, arguments.points_per_site, arguments.dimension, sizeof(Scalar));
  const Index count = arguments.sites * arguments.points_per_site;
  const Box box = Box::unit(arguments.dimension);
  const Points<Scalar> points =
      sample_uniform<Scalar>(box, count, arguments.seed, arguments.distribution, arguments.threads);

  Problem<Scalar> problem(points, arguments.sites, arguments.threads);
  problem.set_domain(arguments.periodic ? Domain::periodic(box) : Domain::euclidean(box));
  if (!arguments.fixed_sites.empty()) {
    const auto fixed = read_sites<Scalar>(arguments.fixed_sites, "fixed sites", arguments.dimension,
                                          arguments.quiet);
    blame(arguments.fixed_sites, [&] {
      check_inside<Scalar>(fixed);
      problem.set_fixed_sites(fixed);
    });
  }
  const auto result = [&] {
    Progress progress(arguments.quiet, arguments.time_limit);
    const Options options = make_options(arguments, Options::samples(), arguments.sites, progress);
    return tessellate(problem, kept.options(options, progress));
  }();

  Publication outputs;
  if (!arguments.points_out.empty()) write_points(arguments.points_out, points);
  if (!arguments.owners_out.empty()) write_owners(arguments.owners_out, result.owners);
  write_summary(arguments, result.summary);
  if (particles) {
    write_particles(arguments.output, result.sites, load);
  } else {
    write_points(arguments.output, result.sites);
  }
  const int status = finish(arguments, outputs, result.summary);
  kept.end(result.summary);
  if (particles && !arguments.quiet) print(describe_particles(arguments.sites, load) + "\n");
  return status;
}

}  // namespace

ScalarType scalar_of(const SampleArguments& arguments) {
  if (arguments.scalar) return *arguments.scalar;
  if (arguments.fixed_sites.empty()) return ScalarType::float32;
  return inspect_points(arguments.fixed_sites).scalar;
}

void check_outputs(const SampleArguments& arguments) {
  Outputs()
      .add("--output", arguments.output, io::kSiteFiles)
      .add("--points-out", arguments.points_out, io::kTableFiles)
      .add("--owners-out", arguments.owners_out, io::kTableFiles)
      .add("--summary", arguments.summary)
      .add_input("--fixed-sites", arguments.fixed_sites)
      .add_input("--checkpoint", checkpoint_file(arguments))
      .check();
}

int run_sample(const SampleArguments& arguments) {
  check_outputs(arguments);
  return scalar_of(arguments) == ScalarType::float64 ? sample<double>(arguments)
                                                     : sample<float>(arguments);
}

}  // namespace ccvt::cli
