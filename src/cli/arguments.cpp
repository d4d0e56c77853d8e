#include "cli/arguments.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/version.h"
#include "cli/argument_kinds.h"
#include "cli/streams.h"
#include "cli/surface.h"
#include "cli/thin_arguments.h"
#include "cli/usage_error.h"
#include "cli/volume_values.h"

namespace ccvt::cli {

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  ccvt stipple photo.png --sites 20000 -o dots.svg\n"
    "  ccvt volume head.nii.gz --sites 20000 -o samples.ply --preview samples.png\n"
    "  ccvt surface bunny.obj --sites 5000 -o samples.ply --preview bunny.png\n"
    "  ccvt thin scan.ply --sites 20000 -o thin.ply\n"
    "  ccvt sample --dim 2 --sites 1024 --periodic -o sites.npy\n"
    "  ccvt sample --dim 3 --sites 262144 --periodic --box-size 100 -o load.hdf5\n"
    "  ccvt tessellate points.csv --sites 100 -o sites.csv --owners-out owners.csv\n"
    "  ccvt analyze sites.npy --periodic -o report\n"
    "\n"
    "Outputs appear together, complete, when all is done; until then the old files stay.\n"
    "Exit status: 0 done, 1 failure, such as a full disk, 2 bad usage or input, or an output\n"
    "that may not be written, 130 stopped by Ctrl-C. That ends reading, analyze and encode at\n"
    "once, and nothing is written; else the tessellation or codebook reached so far is written,\n"
    "unless a second Ctrl-C comes, which quits at once.";

void add_fixed_sites(CLI::App& command, std::filesystem::path& target) {
  add_file(command, "--fixed-sites", target,
           "Sites that stay where they are; they count among --sites, and come first",
           io::kPointFiles);
}

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
  add_file(*command, "--points-out", arguments.points_out, "Write the points too", io::kTableFiles);
  add_file(*command, "--owners-out", arguments.owners_out, "Write the owner of each point too",
           io::kTableFiles);
  add_particles(*command, arguments.particles);
  command->footer(
      "Examples: ccvt sample --dim 2 --sites 1024 --periodic -o sites.npy\n"
      "          ccvt sample --dim 3 --sites 262144 --periodic --box-size 100 -o load.hdf5");
  return command;
}

/// What distances are.
void add_spaces(CLI::App& command, TessellateArguments& arguments) {
  constexpr double infinity = std::numeric_limits<double>::max();
  add_flag(command, "--periodic", arguments.periodic, "Opposite faces of --box are one");
  add_parsed(
      command, "--periodic-along", arguments.periodic_along,
      [](const std::string& text, std::vector<int>& values) {
        return parse_list(text, 0, Range<int>{.least = 1}, values);
      },
      "The same along some dimensions only, from 1", "D,D..");
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

CLI::App* add_tessellate(CLI::App& app, TessellateArguments& arguments) {
  auto* const command = app.add_subcommand("tessellate", "Sites and owners for given points");
  add_file(*command, "POINTS", arguments.points, "Points", io::kPointFiles)->required();
  add_columns(*command, arguments.reading);
  add_sites(*command, arguments.sites, "Number of sites, drawn from the points", false);
  add_file(*command, "--initial-sites", arguments.initial_sites, "Where the sites start",
           io::kPointFiles)
      ->excludes("--sites");
  add_fixed_sites(*command, arguments.fixed_sites);
  add_file(*command, "--capacities", arguments.capacities,
           "How many points each site owns, summing to the number of points, or, with masses, how "
           "much mass [equal]",
           io::kTableFiles);
  add_spaces(*command, arguments);
  add_masses(*command, arguments.mass);
  add_box(*command, arguments.box, "The box that holds the points");
  add_common(*command, arguments, io::kTableFiles, "as the points are stored; text: float64",
             "stable");
  add_file(*command, "--owners-out", arguments.owners_out, "Write the owner of each point too",
           io::kTableFiles);
  command->footer(
      "Examples: ccvt tessellate points.csv --sites 100 --periodic --box 0 0 1 1 -o sites.csv\n"
      "          ccvt tessellate stars.csv --mass-column m --sites 100 -o sites.csv");
  return command;
}

CLI::App* add_stipple(CLI::App& app, StippleArguments& arguments) {
  auto* const command = app.add_subcommand("stipple", "A picture made of equal dots");
  add_file(*command, "IMAGE", arguments.image, "The picture: PNG or JPEG")->required();
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
  auto* const output = command->get_option("--output");
  output->description(output->get_description() + "; the last three hold dot centres in pixels");
  command->footer("Example: ccvt stipple photo.png --sites 20000 -o dots.svg");
  return command;
}

/// Words that start with NAME= start a set; words without go to the set before.
void add_compared(const std::vector<std::string>& words, std::vector<PointFiles>& sets) {
  std::vector<PointFiles> compared;
  for (const std::string& word : words) {
    const auto equals = word.find('=');
    if (equals == std::string::npos && !compared.empty()) {
      compared.back().files.emplace_back(word);
      continue;
    }
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size()) {
      throw CLI::ValidationError("--compare: '" + word + "' is not NAME=FILE");
    }
    const std::string name = word.substr(0, equals);
    if (width_of(name) > 40) {
      throw CLI::ValidationError("--compare: the name '" + name + "' is longer than 40 letters");
    }
    compared.push_back({name, {word.substr(equals + 1)}});
  }
  for (PointFiles& set : compared) {
    for (const PointFiles& other : sets) {
      if (other.name != set.name) continue;
      throw CLI::ValidationError("--compare: there are two sets named '" + set.name + "'");
    }
    sets.push_back(std::move(set));
  }
}

CLI::App* add_analyze(CLI::App& app, AnalyzeArguments& arguments) {
  auto* const command =
      app.add_subcommand("analyze", "How good point sets are: figures, spectra and a report page");
  // Callbacks are called in the order of the options: POINTS are the first set.
  command
      ->add_option_function<std::vector<std::string>>(
          "POINTS",
          [&arguments](const std::vector<std::string>& files) {
            arguments.sets.push_back({"points", {files.begin(), files.end()}});
          },
          "Points: " + io::list_of(io::kPointFiles) +
              ". Several files are runs of one kind, and averaged")
      ->type_name("FILE");
  add_columns(*command, arguments.reading);
  command
      ->add_option_function<std::vector<std::string>>(
          "--compare",
          [&arguments](const std::vector<std::string>& words) {
            add_compared(words, arguments.sets);
          },
          "Further sets, side by side with the first: " + io::list_of(io::kPointFiles) +
              ". Files after one without a name are runs of it")
      ->type_name("NAME=FILE");
  add_flag(*command, "--periodic", arguments.periodic, "Opposite faces of the box are one");
  add_box(*command, arguments.box,
          "The box that the points fill [the unit box; of .gadget and .hdf5 the periodic one they "
          "name]");
  add_number<double>(*command, "--max-frequency", arguments.max_frequency,
                     "Up to which frequency, in units of n^(1/D) in the unit box [2]", "F",
                     {.least = 0, .most = 1000, .open_below = true});
  add_file(*command, "-o,--output", arguments.output,
           "The directory for metrics.json, report.html and the rest; made if need be")
      ->type_name("DIR")
      ->required();
  add_seed_and_threads(*command, arguments.seed, arguments.threads);
  add_flag(*command, "-q,--quiet", arguments.quiet, "Print nothing but errors");
  command->footer(
      "Examples: ccvt analyze run1.npy run2.npy --periodic -o report\n"
      "          ccvt analyze ours.npy --compare theirs=a.csv white=b.csv --periodic -o report");
  return command;
}

CLI::App* add_volume(CLI::App& app, VolumeArguments& arguments) {
  auto* const command = app.add_subcommand("volume", "Samples that follow a scalar field in 3D");
  add_file(*command, "FILE", arguments.volume, "The field", io::kVolumeFiles)->required();
  add_sites(*command, arguments.sites, "Number of samples", true);
  add_points_per_site(*command, arguments.points_per_site);
  add_parsed(*command, "--map", arguments.map, parse_map,
             "How values become densities: linear, window:LO,HI, threshold:T, gamma:G [linear]",
             "MAP");
  add_flag(*command, "--invert", arguments.map.invert, "Dense where values are low");
  add_parsed(*command, "--interpolation", arguments.interpolation, parse_interpolation,
             "Of the density between the centres of cells: constant, linear [linear]", "NAME");
  add_file(*command, "--mask", arguments.mask, "A volume that is 0 or NaN where samples may not be",
           io::kVolumeFiles);
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
  constexpr double infinity = std::numeric_limits<double>::max();
  add_parsed(*command, "--spacing", arguments.layout.spacing,
             three({.least = 0, .most = infinity, .open_below = true}),
             "Of .raw and .npy: distance of the cells along each axis [1,1,1]", "X,Y,Z");
  add_parsed(*command, "--origin", arguments.layout.origin, three({}),
             "Of .raw and .npy: centre of the first cell [0,0,0]", "X,Y,Z");
  add_parsed(
      *command, "--shape", arguments.layout.shape,
      [](const std::string& text, std::vector<std::int64_t>& values) {
        return parse_list(text, 3, Range<std::int64_t>{.least = 1}, values);
      },
      "Of .raw: cells along each axis, the first one fastest", "X,Y,Z");
  add_parsed(*command, "--type", arguments.layout, parse_voxel_type,
             "Of .raw: uint8, int16, float32, …; int16be: big endian", "TYPE");
  add_common(*command, arguments, io::kSampleFiles, "float32");
  add_file(*command, "--preview", arguments.preview,
           "Draw the field along its three axes, with the samples over it", io::kPictureFiles);
  command->footer(
      "Example: ccvt volume head.nii.gz --sites 20000 -o samples.ply --preview samples.png");
  return command;
}

CLI::App* add_quantize(CLI::App& app, QuantizeArguments& arguments) {
  auto* const command = app.add_subcommand("quantize", "A codebook for given vectors");
  add_file(*command, "VECTORS", arguments.vectors,
           "With --image-blocks a PNG or JPEG, else vectors", io::kPointFiles)
      ->required();
  add_columns(*command, arguments.reading);
  add_number<Index>(*command, "--codewords", arguments.codewords, "Number of codewords", "K",
                    {.least = 1})
      ->required();
  static const std::map<std::string, CodebookMethod> names = {
      {"exact", CodebookMethod::exact},
      {"pairwise", CodebookMethod::pairwise},
      {"lloyd", CodebookMethod::lloyd}};
  command
      ->add_option_function<std::string>(
          "--method", [&arguments](const std::string& name) { arguments.method = names.at(name); },
          "exact: equal cells, cheapest assignment; pairwise: equal cells, as tessellate; lloyd: "
          "k-means, cells of any size [exact]")
      ->type_name("NAME")
      ->check(CLI::Validator(
          [](std::string& name) {
            if (names.contains(name)) return std::string();
            return "'" + name + "' is not one of exact, pairwise, lloyd";
          },
          ""));
  command
      ->add_option_function<std::string>(
          "--seeding", [&arguments](const std::string& text) { arguments.seeding = text; },
          "kmeans++, random, or a file of codewords to start from, " +
              io::list_of(io::kPointFiles) + " [kmeans++]")
      ->type_name("HOW");
  add_number<int>(*command, "--restarts", arguments.restarts,
                  "Seedings tried on a sample; the best is used; 0: as many as pay, 1 or 4 [0]",
                  "R", {.least = 0, .most = 1'000'000});
  add_number<int>(
      *command, "--effort", arguments.effort,
      "Codebooks bred from the seedings on a sample, toward the best equal cells whatever "
      "the seed [32 to 64 for up to 128 codewords and dimensions, else 0]",
      "E", {.least = 0, .most = 1'000'000});
  add_number<double>(*command, "--gap", arguments.gap,
                     "Assignments that cost at most this share more than the cheapest will do [0]",
                     "G", {.least = 0, .most = 1, .open_above = true});
  add_file(*command, "--capacities", arguments.capacities,
           "How many vectors each codeword gets, summing to their number [equal]", io::kTableFiles);
  add_file(*command, "-o,--output", arguments.output, "Where the codewords go", io::kTableFiles)
      ->required();
  add_file(*command, "--codes-out", arguments.codes_out, "Write the code of each vector too",
           io::kTableFiles);
  add_file(*command, "--weights-out", arguments.weights_out,
           "Write the weights of the codewords too, for ccvt encode --weights", io::kTableFiles);
  add_number<int>(*command, "--image-blocks", arguments.image_blocks,
                  "Take the B x B blocks of a picture for vectors of 3 B^2 values, 0 to 255", "B",
                  {.least = 1, .most = 256});
  add_file(*command, "--image-out", arguments.image_out,
           "Write the picture that the codes stand for", io::kPictureFiles);
  add_run(*command, arguments);
  command->footer(
      "Example: ccvt quantize vectors.fvecs --codewords 1024 -o codebook.npy --codes-out "
      "codes.npy");
  return command;
}

CLI::App* add_encode(CLI::App& app, EncodeArguments& arguments) {
  auto* const command = app.add_subcommand("encode", "The code of each vector");
  add_file(*command, "VECTORS", arguments.vectors, "Vectors", io::kPointFiles)->required();
  add_columns(*command, arguments.reading);
  add_file(*command, "--codebook", arguments.codebook, "The codewords, from ccvt quantize",
           io::kPointFiles)
      ->required();
  add_file(*command, "--weights", arguments.weights,
           "Their weights: codes are used as evenly as in training [nearest codeword]",
           io::kPointFiles);
  add_file(*command, "-o,--output", arguments.output, "Where the codes go", io::kTableFiles)
      ->required();
  add_number<int>(*command, "--threads", arguments.threads,
                  "Threads; 0: one per processor [0]. The result is the same for any number", "T",
                  {.least = 0, .most = 4096});
  add_flag(*command, "-q,--quiet", arguments.quiet, "Print nothing but errors");
  command->footer(
      "Example: ccvt encode new.fvecs --codebook codebook.npy --weights w.npy -o codes.npy");
  return command;
}

}  // namespace

int run_command_line(int argc, const char* const* argv) {
  CLI::App app("Capacity-constrained Voronoi tessellation in any dimension", "ccvt");
  app.set_version_flag("--version", "ccvt " CCVT_VERSION);
  app.require_subcommand(1);
  app.footer(kExamples);
  app.get_formatter()->column_width(34);
  SampleArguments sample;
  TessellateArguments tessellate;
  StippleArguments stipple;
  AnalyzeArguments analyze;
  QuantizeArguments quantize;
  EncodeArguments encode;
  VolumeArguments volume;
  SurfaceArguments surface;
  ThinArguments thin;
  const std::vector<std::pair<const CLI::App*, std::function<int()>>> commands = {
      {add_sample(app, sample), [&] { return run_sample(sample); }},
      {add_tessellate(app, tessellate), [&] { return run_tessellate(tessellate); }},
      {add_stipple(app, stipple), [&] { return run_stipple(stipple); }},
      {add_volume(app, volume), [&] { return run_volume(volume); }},
      {add_surface(app, surface), [&] { return run_surface(surface); }},
      {add_thin(app, thin), [&] { return run_thin(thin); }},
      {add_analyze(app, analyze), [&] { return run_analyze(analyze); }},
      {add_quantize(app, quantize), [&] { return run_quantize(quantize); }},
      {add_encode(app, encode), [&] { return run_encode(encode); }},
  };
  try {
    app.parse(reversed_arguments(argc, argv));
  } catch (const CLI::Success& success) {  // help, version
    std::ostringstream text;
    const int status = app.exit(success, text);
    print(text.str());
    return status;
  } catch (const CLI::ParseError& error) {
    throw InvalidInput(usage_error(app, error));
  }
  const auto given = std::find_if(commands.begin(), commands.end(),
                                  [](const auto& command) { return command.first->parsed(); });
  return given->second();
}

}  // namespace ccvt::cli
