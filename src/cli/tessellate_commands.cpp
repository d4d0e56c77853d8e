#include <limits>
#include <map>
#include <string>
#include <vector>

#include "cli/argument_kinds.h"
#include "cli/commands.h"
#include "cli/volume_values.h"

namespace ccvt::cli {

namespace {

void add_fixed_sites(CLI::App& command, std::filesystem::path& target) {
  add_input(command, "--fixed-sites", target,
            "Sites that stay where they are; they count among --sites, and come first",
            io::kPointFiles);
}

/// What distances are.
void add_spaces(CLI::App& command, TessellateArguments& arguments) {
  constexpr double infinity = std::numeric_limits<double>::max();
  add_flag(command, "--periodic", arguments.periodic,
           "Opposite faces of --box, or of a particle load's, are one");
  auto* const along = add_parsed(
      command, "--periodic-along", arguments.periodic_along,
      [](const std::string& text, std::vector<int>& values) {
        return parse_list(text, 0, Range<int>{.least = 1}, values);
      },
      "The same along some dimensions only, from 1", "D,D..");
  along->excludes("--periodic");
  add_parsed(
      command, "--units", arguments.units,
      [](const std::string& text, std::vector<double>& values) {
        return parse_list(text, 0, Range<double>{.least = 0, .most = infinity, .open_below = true},
                          values);
      },
      "What coordinates are multiplied by where distances are measured [1]", "F,F..");
  add_flag(command, "--whiten", arguments.whiten,
           "Distances in units of the points' spread along each direction (Mahalanobis)");
}

}  // namespace

CLI::App* add_sample(CLI::App& app, SampleArguments& arguments) {
  auto* const command =
      app.add_subcommand("sample", "Sites spread evenly over the unit box [0, 1]^D");
  add_number<int>(*command, "-d,--dim", arguments.dimension, "Dimensions", "D", {.least = 1})
      ->required();
  add_sites(*command, arguments.sites, "Number of sites", true);
  add_points_per_site(*command, arguments.points_per_site);
  add_flag(*command, "--periodic", arguments.periodic, "Opposite faces of the box are one");
  add_fixed_sites(*command, arguments.fixed_sites);
  static const std::map<std::string, Distribution> names = {{"white", Distribution::white},
                                                            {"jittered", Distribution::jittered},
                                                            {"square", Distribution::square},
                                                            {"hexagonal", Distribution::hexagonal}};
  command
      ->add_option_function<std::string>(
          "--distribution",
          [&arguments](const std::string& name) { arguments.distribution = names.at(name); },
          "How the points lie: white, jittered, square or hexagonal [jittered]")
      ->type_name("NAME")
      ->check(CLI::Validator(
          [](std::string& name) {
            if (names.contains(name)) return std::string();
            return "'" + name + "' is not one of white, jittered, square, hexagonal";
          },
          ""));
  add_common(*command, arguments, io::kSiteFiles, "float32");
  add_checkpoint(*command, arguments);
  add_output(*command, "--points-out", arguments.points_out, "Write the points too",
             io::kTableFiles);
  add_output(*command, "--owners-out", arguments.owners_out, "Write the owner of each point too",
             io::kTableFiles);
  add_particles(*command, arguments.particles);
  command->footer(
      "Examples: ccvt sample --dim 2 --sites 1024 --periodic -o sites.npy\n"
      "          ccvt sample --dim 3 --sites 262144 --periodic --box-size 100 -o load.hdf5");
  return command;
}

CLI::App* add_tessellate(CLI::App& app, TessellateArguments& arguments) {
  auto* const command = app.add_subcommand("tessellate", "Sites and owners for given points");
  add_input(*command, "POINTS", arguments.points, "Points", io::kPointFiles)->required();
  add_columns(*command, arguments.reading);
  add_sites(*command, arguments.sites,
            "Number of sites, drawn from the points [as many as --capacities]", false);
  add_input(*command, "--initial-sites", arguments.initial_sites, "Where the sites start",
            io::kPointFiles)
      ->excludes("--sites");
  add_fixed_sites(*command, arguments.fixed_sites);
  add_input(*command, "--capacities", arguments.capacities,
            "How many points each site owns, summing to the number of points, or, with masses, how "
            "much mass [equal]",
            io::kTableFiles);
  add_spaces(*command, arguments);
  add_masses(*command, arguments.mass);
  add_box(*command, arguments.box,
          "The box that holds the points [of a particle load that is periodic its own]");
  add_common(*command, arguments, io::kTableFiles, "as the points are stored; text: float64",
             "stable");
  add_checkpoint(*command, arguments);
  add_output(*command, "--owners-out", arguments.owners_out, "Write the owner of each point too",
             io::kTableFiles);
  command->footer(
      "Examples: ccvt tessellate points.csv --sites 100 --periodic --box 0 0 1 1 -o sites.csv\n"
      "          ccvt tessellate stars.csv --mass-column m --sites 100 -o sites.csv");
  return command;
}

}  // namespace ccvt::cli
