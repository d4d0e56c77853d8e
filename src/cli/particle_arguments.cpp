#include "cli/particle_arguments.h"

#include <limits>

#include "cli/argument_kinds.h"
#include "cli/arguments.h"
#include "cli/outputs.h"
#include "io/formats.h"

namespace ccvt::cli {

void add_particles(CLI::App& app, ParticleArguments& arguments) {
  const std::string of = "Of " + io::list_of(io::kParticleFiles, " and ") + ": ";
  constexpr double infinity = std::numeric_limits<double>::max();
  add_number<double>(app, "--box-size", arguments.box_size, of + "side of the periodic box [1]",
                     "L", {.least = 1e-30, .most = 1e30});
  add_number<int>(app, "--repeat", arguments.repeat,
                  of + "so many copies of the sites along each axis fill the box [1]", "R",
                  {.least = 1, .most = 1000});
  add_number<double>(app, "--density", arguments.density,
                     of + "mean density: a particle's mass is RHO L^3 / #particles [1]", "RHO",
                     {.least = 0, .most = infinity, .open_below = true});
  add_number<double>(app, "--redshift", arguments.redshift,
                     of + "redshift in the header; Time is 1 / (1 + Z) [0]", "Z",
                     {.least = 0, .most = infinity});
  add_flag(app, "--gas", arguments.gas, of + "gas (type 0), not dark matter (type 1)");
  add_number<int>(app, "--gadget-format", arguments.gadget_format,
                  "Of .gadget: 1, or 2, with labels [1]", "F", {.least = 1, .most = 2});
}

bool makes_particles(const SampleArguments& arguments) {
  const ParticleArguments& given = arguments.particles;
  const std::string extension = io::extension_of(arguments.output);
  const bool particles = io::is_among(io::kParticleFiles, extension);
  const std::pair<const char*, bool> options[] = {{"--box-size", given.box_size.has_value()},
                                                  {"--repeat", given.repeat.has_value()},
                                                  {"--density", given.density.has_value()},
                                                  {"--redshift", given.redshift.has_value()},
                                                  {"--gas", given.gas}};
  for (const auto& [name, is_given] : options) {
    if (particles || !is_given) continue;
    throw InvalidInput(std::string(name) + ": is for particles, which go into " +
                       io::list_of(io::kParticleFiles, " or ") + ", not into '" + extension + "'");
  }
  if (given.gadget_format && extension != ".gadget") {
    throw InvalidInput("--gadget-format: is for .gadget, not for '" + extension + "'");
  }
  if (particles && arguments.dimension != 3) {
    throw InvalidInput(arguments.output.string() + ": particles have 3 dimensions, not --dim " +
                       std::to_string(arguments.dimension));
  }
  if (particles && !arguments.periodic) {
    throw InvalidInput(arguments.output.string() +
                       ": particles fill a periodic box: --periodic is needed");
  }
  return particles;
}

ParticleOptions particle_options(const ParticleArguments& arguments) {
  ParticleOptions options;
  options.box_size = arguments.box_size.value_or(options.box_size);
  options.repeat = arguments.repeat.value_or(options.repeat);
  options.density = arguments.density.value_or(options.density);
  options.redshift = arguments.redshift.value_or(options.redshift);
  options.gadget_format = arguments.gadget_format.value_or(options.gadget_format);
  if (arguments.gas) options.type = ParticleType::gas;
  return options;
}

}  // namespace ccvt::cli
