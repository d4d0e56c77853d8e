#include "cli/mass_arguments.h"

#include "cli/argument_kinds.h"
#include "io/formats.h"

namespace ccvt::cli {

void add_masses(CLI::App& app, MassArguments& target) {
  add_input(app, "--masses", target.file, "The mass of each point, not negative", io::kTableFiles);
  app.add_option("--mass-column", target.column,
                 "The column of POINTS that is their mass, by name or number from 1")
      ->type_name("COLUMN")
      ->excludes("--masses");
  add_parsed(
      app, "--mass-method", target.method,
      [](const std::string& name, std::optional<MassMethod>& method) {
        if (name == to_string(MassMethod::whole)) method = MassMethod::whole;
        if (name == to_string(MassMethod::resampled)) method = MassMethod::resampled;
        if (name == "whole" || name == "resampled") return std::string();
        return "'" + name + "' is not one of whole, resampled";
      },
      "whole: every point has one owner, cells miss their capacity by less than the heaviest "
      "point; resampled: unit points in place of masses, heavy points are shared [whole]",
      "NAME");
  add_output(app, "--shares-out", target.shares_out,
             "With --mass-method resampled: write a row for each share: the point, the site, both "
             "from 0, and the mass",
             io::kTableFiles);
  add_number<Index>(app, "--points-per-site", target.points_per_site,
                    "With masses: unit points for each site [256]", "K", {.least = 1});
}

}  // namespace ccvt::cli
