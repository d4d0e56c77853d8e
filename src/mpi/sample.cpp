#include "cli/sample.h"

#include <cstdint>
#include <string>

#include "ccvt/io.h"
#include "ccvt/particles.h"
#include "ccvt/problem.h"
#include "ccvt/sampling.h"
#include "ccvt/solver.h"
#include "cli/outputs.h"
#include "commands.h"
#include "results.h"

namespace ccvt::mpi {
namespace {

using cli::SampleArguments;

template <class Scalar>
int sample(const Session& session, const SampleArguments& arguments) {
  const Kept kept(session, arguments);
  const bool particles = makes_particles(arguments);
  const ParticleOptions load = particle_options(arguments.particles);
  const std::int64_t all = std::int64_t{arguments.sites} * arguments.points_per_site;
  session.together([&] { Session::check_count(arguments.sites, arguments.points_per_site); });
  const Session::Share share = session.share(all);
  const Box box = Box::unit(arguments.dimension);
  Points<Scalar> points;
  Points<Scalar> fixed;
  session.together([&] {
    if (particles) check_particles(arguments.output, arguments.sites, sizeof(Scalar), load);
    session.check_memory("--sites " + std::to_string(arguments.sites), share.size(),
                         arguments.dimension, sizeof(Scalar), arguments.points_per_site);
    points = sample_uniform_part<Scalar>(box, all, share.begin, share.end, arguments.seed,
                                         arguments.distribution, arguments.threads);
    if (arguments.fixed_sites.empty()) return;
    fixed = cli::read_sites<Scalar>(arguments.fixed_sites, "fixed sites", arguments.dimension,
                                    arguments.quiet);
    cli::blame(arguments.fixed_sites, [&] { cli::check_inside<Scalar>(fixed); });
  });
  Problem<Scalar> problem(session.ranks(), view_points(points), arguments.sites, arguments.threads);
  problem.set_domain(arguments.periodic ? Domain::periodic(box) : Domain::euclidean(box));
  if (fixed.size() > 0) {
    cli::blame(arguments.fixed_sites, [&] { problem.set_fixed_sites(fixed); });
  }
  const auto result = kept.solve(Options::samples(), arguments.sites, [&](const Options& options) {
    return tessellate(problem, options);
  });

  OwnersFile owners(session, arguments.owners_out, all);
  owners.write(share.begin, result.owners);
  std::optional<SharedFile> points_file;
  if (!arguments.points_out.empty()) {
    points_file.emplace(session, arguments.points_out, sizeof(Scalar) == 4 ? "<f4" : "<f8",
                        static_cast<std::uint64_t>(all),
                        static_cast<std::uint64_t>(arguments.dimension),
                        sizeof(Scalar) * static_cast<std::size_t>(arguments.dimension));
    points_file->write(
        static_cast<std::uint64_t>(share.begin),
        std::as_bytes(std::span(points.data(), static_cast<std::size_t>(points.size()))));
  }
  return finish(session, arguments, kept, result.summary, [&] {
    if (points_file) points_file->publish();
    owners.publish();
    if (particles) {
      write_particles(arguments.output, result.sites, load);
    } else {
      write_points(arguments.output, result.sites);
    }
  });
}

}  // namespace

int run_sample(const Session& session, const SampleArguments& given) {
  const SampleArguments arguments = session.own(given);
  session.together([&] {
    require_npy("--points-out", arguments.points_out);
    require_npy("--owners-out", arguments.owners_out);
    require_balanced(arguments, "--dim", arguments.dimension);
    if (session.is_first()) check_outputs(arguments);
  });
  ScalarType scalar{};
  session.together([&] { scalar = cli::scalar_of(arguments); });
  return scalar == ScalarType::float64 ? sample<double>(session, arguments)
                                       : sample<float>(session, arguments);
}

}  // namespace ccvt::mpi
