#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "cli/argument_kinds.h"
#include "cli/commands.h"
#include "cli/volume_values.h"

namespace ccvt::cli {

CLI::App* add_stipple(CLI::App& app, StippleArguments& arguments) {
  auto* const command = app.add_subcommand("stipple", "A picture made of equal dots");
  add_input(*command, "IMAGE", arguments.image, "The picture: PNG or JPEG")->required();
  add_sites(*command, arguments.sites, "Number of dots", true);
  add_points_per_site(*command, arguments.points_per_site);
  add_flag(*command, "--invert", arguments.invert, "Put the dots where the picture is light");
  constexpr double infinity = std::numeric_limits<double>::max();
  add_number<double>(*command, "--gamma", arguments.gamma,
                     "Exponent on the darkness; above 1: fewer dots in light parts [1]", "G",
                     {.least = 0, .most = infinity, .open_below = true});
  add_number<double>(*command, "--dot-radius", arguments.dot_radius,
                     "In pixels of the picture [such that dots cover as much as is dark]", "R",
                     {.least = 0, .most = infinity, .open_below = true});
  add_common(*command, arguments, io::kStippleFiles, "float32");
  add_checkpoint(*command, arguments);
  auto* const output = command->get_option("--output");
  output->description(output->get_description() + "; the last three hold dot centres in pixels");
  command->footer("Example: ccvt stipple photo.png --sites 20000 -o dots.svg");
  return command;
}

CLI::App* add_volume(CLI::App& app, VolumeArguments& arguments) {
  auto* const command = app.add_subcommand("volume", "Samples that follow a scalar field in 3D");
  add_input(*command, "FILE", arguments.volume, "The field", io::kVolumeFiles)->required();
  add_sites(*command, arguments.sites, "Number of samples", true);
  add_points_per_site(*command, arguments.points_per_site);
  add_parsed(*command, "--map", arguments.map, parse_map,
             "How values become densities: linear, window:LO,HI, threshold:T, gamma:G [linear]",
             "MAP");
  add_flag(*command, "--invert", arguments.map.invert, "Dense where values are low");
  add_parsed(*command, "--interpolation", arguments.interpolation, parse_interpolation,
             "Of the density between the centres of cells: constant, linear [linear]", "NAME");
  add_input(*command, "--mask", arguments.mask,
            "A volume that is 0 or NaN where samples may not be", io::kVolumeFiles);
  add_parsed(
      *command, "--label", arguments.labels,
      [](const std::string& text, std::vector<std::int64_t>& values) {
        return parse_list(text, 0, Range<std::int64_t>{}, values);
      },
      "Values of --mask where samples may be [all but 0]", "L,L..");
  const auto three = [](const Range<double>& range) {
    return [range](const std::string& text, std::vector<double>& values) {
      return parse_list(text, 3, range, values);
    };
  };
  constexpr double least = 1e-30;
  constexpr double most = 1e30;
  add_parsed(*command, "--spacing", arguments.layout.spacing, three({.least = least, .most = most}),
             "Of .raw and .npy: distance of the cells along each axis [1,1,1]", "X,Y,Z");
  add_parsed(*command, "--origin", arguments.layout.origin, three({.least = -most, .most = most}),
             "Of .raw and .npy: centre of the first cell [0,0,0]", "X,Y,Z");
  add_parsed(
      *command, "--shape", arguments.layout.shape,
      [](const std::string& text, std::vector<std::int64_t>& values) {
        return parse_list(text, 3, Range<std::int64_t>{.least = 1}, values);
      },
      "Of .raw: cells along each axis, the first one fastest", "X,Y,Z");
  add_parsed(*command, "--type", arguments.layout, parse_voxel_type,
             "Of .raw: uint8, int16, float32 and so on; int16be: big endian", "TYPE");
  add_parsed(*command, "--mask-type", arguments.mask_layout, parse_voxel_type,
             "Of a .raw --mask, if it is not --type", "TYPE");
  add_common(*command, arguments, io::kSampleFiles, "float32");
  describe_samples(*command);
  add_checkpoint(*command, arguments);
  add_output(*command, "--preview", arguments.preview,
             "Draw the field along its three axes, with the samples over it", io::kPictureFiles);
  command->footer(
      "Example: ccvt volume head.nii.gz --sites 20000 -o samples.ply --preview samples.png");
  return command;
}

}  // namespace ccvt::cli
