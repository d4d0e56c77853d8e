#include "cli/arguments.h"

#include <CLI/CLI.hpp>
#include <functional>
#include <map>

#include "ccvt/version.h"
#include "cli/values.h"

namespace ccvt::cli {

namespace {

constexpr const char* kExamples =
    "Examples:\n"
    "  ccvt stipple photo.png --sites 20000 -o dots.svg\n"
    "  ccvt sample --dim 2 --sites 1024 --periodic -o sites.npy\n"
    "  ccvt tessellate points.csv --sites 100 -o sites.csv --owners-out owners.csv\n"
    "\n"
    "Exit status: 0 done, 1 failure, 2 bad input or an output that cannot be written, 130 stopped\n"
    "by Ctrl-C; the tessellation reached so far is then written. A second Ctrl-C quits at once.";

/// An option whose value is parsed strictly, with messages that say what it must be.
template <class Number, class Target>
CLI::Option* add_number(CLI::App& app, const std::string& name, Target& target,
                        const std::string& description, const char* placeholder,
                        Range<Number> range) {
  const auto parse = [&target, range](const std::string& text) {
    Number value{};
    const std::string wrong = parse_number(text, range, value);
    if (!wrong.empty()) throw CLI::ValidationError(wrong);
    target = value;
  };
  auto* const option = app.add_option_function<std::string>(name, parse, description);
  option->type_name(placeholder);
  // As a check, so that the message carries the option's name.
  option->check(CLI::Validator(
      [range](std::string& text) {
        Number value{};
        return parse_number(text, range, value);
      },
      ""));
  return option;
}

CLI::Option* add_file(CLI::App& app, const std::string& name, std::filesystem::path& target,
                      const std::string& description) {
  auto* const option = app.add_option_function<std::string>(
      name, [&target](const std::string& text) { target = text; }, description);
  option->type_name("FILE");
  option->check(CLI::Validator(
      [](std::string& text) { return text.empty() ? std::string("is empty") : std::string(); },
      ""));
  return option;
}

void add_sites(CLI::App& app, Index& target, const std::string& description, bool required) {
  add_number<Index>(app, "--sites", target, description, "N", {.least = 1})->required(required);
}

void add_points_per_site(CLI::App& app, Index& target) {
  add_number<Index>(app, "--points-per-site", target, "Points for each site [256]", "K",
                    {.least = 1});
}

void add_common(CLI::App& app, CommonArguments& common, const std::string& formats) {
  common.command = app.get_name();
  add_file(app, "-o,--output", common.output, "Where the sites go: " + formats)->required();
  add_number<std::uint64_t>(app, "--seed", common.seed, "Fixes every random choice [0]", "S",
                            {.least = 0});
  add_number<int>(app, "--threads", common.threads,
                  "Threads; 0: one per processor [0]. The result is the same for any number", "T",
                  {.least = 0, .most = 4096});
  add_number<int>(app, "--max-iterations", common.max_iterations,
                  "Stop after this many iterations [until stable]", "K", {.least = 0});
  add_number<double>(app, "--energy-tolerance", common.energy_tolerance,
                     "Stop when an iteration lowers the energy by less than this share [0]", "E",
                     {.least = 0, .most = 1, .open_above = true});
  auto* const single = app.add_flag_function(
      "--float", [&common](std::int64_t) { common.scalar = ScalarType::float32; },
      "Compute and write in float32 [as POINTS are stored; float32 without POINTS]");
  auto* const wide = app.add_flag_function(
      "--double", [&common](std::int64_t) { common.scalar = ScalarType::float64; },
      "Compute and write in float64");
  single->excludes(wide);
  add_file(app, "--summary", common.summary, "Write a summary of the run as JSON");
  app.add_flag("-q,--quiet", common.quiet, "Print nothing but errors");
}

CLI::App* add_sample(CLI::App& app, SampleArguments& arguments) {
  auto* const command =
      app.add_subcommand("sample", "Sites spread evenly over the unit box [0, 1]^D");
  add_number<int>(*command, "-d,--dim", arguments.dimension, "Dimensions", "D", {.least = 1})
      ->required();
  add_sites(*command, arguments.sites, "Number of sites", true);
  add_points_per_site(*command, arguments.points_per_site);
  command->add_flag("--periodic", arguments.periodic, "Opposite faces of the box are one");
  static const std::map<std::string, Distribution> names = {
      {"white", Distribution::white},
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
            if (names.count(name) != 0) return std::string();
            return "'" + name + "' is not one of white, jittered, square, hexagonal";
          },
          ""));
  add_common(*command, arguments, ".npy, .csv, .txt");
  add_file(*command, "--points-out", arguments.points_out, "Write the points too");
  add_file(*command, "--owners-out", arguments.owners_out, "Write the owner of each point too");
  command->footer("Example: ccvt sample --dim 2 --sites 1024 --periodic -o sites.npy");
  return command;
}

CLI::App* add_tessellate(CLI::App& app, TessellateArguments& arguments) {
  auto* const command = app.add_subcommand("tessellate", "Sites and owners for given points");
  add_file(*command, "POINTS", arguments.points, "Points: .npy, .csv, .txt")->required();
  add_sites(*command, arguments.sites, "Number of sites, drawn from the points", false);
  add_file(*command, "--initial-sites", arguments.initial_sites, "Where the sites start")
      ->excludes("--sites");
  add_file(*command, "--capacities", arguments.capacities,
           "How many points each site owns, summing to the number of points [equal]");
  command->add_flag("--periodic", arguments.periodic, "Opposite faces of --box are one");
  command
      ->add_option_function<std::vector<std::string>>(
          "--box",
          [&arguments](const std::vector<std::string>& texts) {
            for (const auto& text : texts) {
              parse_number(text, Range<double>{}, arguments.box.emplace_back());
            }
          },
          "The box that holds the points: all lower bounds, then all upper bounds")
      ->type_name("LO.. HI..")
      ->expected(2, 1 << 20)
      ->check(CLI::Validator(
          [](std::string& text) {
            double value = 0;
            return parse_number(text, Range<double>{}, value);
          },
          ""));
  add_common(*command, arguments, ".npy, .csv, .txt");
  add_file(*command, "--owners-out", arguments.owners_out, "Write the owner of each point too");
  command->footer(
      "Example: ccvt tessellate points.csv --sites 100 --periodic --box 0 0 1 1 -o sites.csv");
  return command;
}

CLI::App* add_stipple(CLI::App& app, StippleArguments& arguments) {
  auto* const command = app.add_subcommand("stipple", "A picture made of equal dots");
  add_file(*command, "IMAGE", arguments.image, "The picture: PNG or JPEG")->required();
  add_sites(*command, arguments.sites, "Number of dots", true);
  add_points_per_site(*command, arguments.points_per_site);
  command->add_flag("--invert", arguments.invert, "Put the dots where the picture is light");
  constexpr double infinity = std::numeric_limits<double>::max();
  add_number<double>(*command, "--gamma", arguments.gamma,
                     "Exponent on the darkness; above 1: fewer dots in light parts [1]", "G",
                     {.least = 0, .most = infinity, .open_below = true});
  add_number<double>(*command, "--dot-radius", arguments.dot_radius,
                     "In pixels of the picture [such that dots cover as much as is dark]", "R",
                     {.least = 0, .most = infinity, .open_below = true});
  add_common(*command, arguments, ".svg, .png; dot centres in pixels: .csv, .txt, .npy");
  command->footer("Example: ccvt stipple photo.png --sites 20000 -o dots.svg");
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
  const CLI::App* const sample_command = add_sample(app, sample);
  const CLI::App* const tessellate_command = add_tessellate(app, tessellate);
  add_stipple(app, stipple);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // help, version
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    throw InvalidInput(std::string(error.what()) + "; see ccvt --help");
  }
  if (sample_command->parsed()) return run_sample(sample);
  if (tessellate_command->parsed()) return run_tessellate(tessellate);
  return run_stipple(stipple);
}

}  // namespace ccvt::cli
