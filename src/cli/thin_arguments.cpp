#include "cli/thin_arguments.h"

#include <limits>

#include "cli/argument_kinds.h"

namespace ccvt::cli {

CLI::App* add_thin(CLI::App& app, ThinArguments& arguments) {
  auto* const command = app.add_subcommand(
      "thin", "Some of the points of a cloud, evenly spread, and all they carry");
  add_input(*command, "POINTS", arguments.points, "Points", io::kPointFiles)->required();
  add_columns(*command, arguments.reading);
  add_sites(*command, arguments.sites, "How many points to choose", false);
  constexpr double infinity = std::numeric_limits<double>::max();
  add_number<double>(*command, "--ratio", arguments.ratio,
                     "Choose one point in so many, instead of --sites", "R",
                     {.least = 1, .most = infinity})
      ->excludes("--sites");
  add_number<double>(*command, "--normal-weight", arguments.normal_weight,
                     "How much normals nx, ny, nz count, where the file has them: opposite ones as "
                     "2 W spacings; 0: not at all [0.5]",
                     "W", {.least = 0, .most = 100});
  add_flag(*command, "--equal-counts", arguments.equal_counts,
           "Equally many points count for each chosen one, some of them from farther away, instead "
           "of each point for the nearest");
  add_common(*command, arguments, io::kThinFiles, "as the points are stored; text: float64");
  auto* const output = command->get_option("--output");
  output->description(
      "Where the chosen points go, with how many points each stands for, but in .npy: " +
      io::list_of(io::kThinFiles) + ". From PLY to PLY and text to text with all that they carry");
  // Whose numbers are those that were read.
  command->get_option("--float")->description("Choose in float32");
  command->get_option("--double")
      ->description("Choose in float64 [default: as the points are stored; text: float64]");
  add_output(*command, "--indices-out", arguments.indices_out,
             "Write which points were chosen, from 0", io::kTableFiles);
  add_output(*command, "--owners-out", arguments.owners_out,
             "Write for which of the chosen points each point counts, from 0", io::kTableFiles);
  command->footer("Example: ccvt thin scan.ply --sites 20000 -o thin.ply");
  return command;
}

}  // namespace ccvt::cli
