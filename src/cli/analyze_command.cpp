#include <string>
#include <utility>
#include <vector>

#include "cli/argument_kinds.h"
#include "cli/commands.h"
#include "cli/standard_streams.h"

namespace ccvt::cli {

namespace {

std::filesystem::path points_file(const std::string& option, const std::string& text) {
  return file_of(option, text, Stream::input, io::kPointFiles);
}

/// Words that start with NAME= start a set; words without go to the set before.
void add_compared(const std::vector<std::string>& words, std::vector<PointFiles>& sets) {
  std::vector<PointFiles> compared;
  for (const std::string& word : words) {
    const auto equals = word.find('=');
    if (equals == std::string::npos && !compared.empty()) {
      compared.back().files.push_back(points_file("--compare", word));
      continue;
    }
    if (equals == std::string::npos || equals == 0 || equals + 1 == word.size()) {
      throw CLI::ValidationError("--compare: '" + word + "' is not NAME=FILE");
    }
    const std::string name = word.substr(0, equals);
    if (width_of(name) > 40) {
      throw CLI::ValidationError("--compare: the name '" + name + "' is longer than 40 letters");
    }
    compared.push_back({name, {points_file("--compare", word.substr(equals + 1))}});
  }
  for (PointFiles& set : compared) {
    for (const PointFiles& other : sets) {
      if (other.name != set.name) continue;
      throw CLI::ValidationError("--compare: there are two sets named '" + set.name + "'");
    }
    sets.push_back(std::move(set));
  }
}

}  // namespace

CLI::App* add_analyze(CLI::App& app, AnalyzeArguments& arguments) {
  auto* const command =
      app.add_subcommand("analyze", "How good point sets are: figures, spectra and a report page");
  // Callbacks are called in the order of the options: POINTS are the first set.
  command
      ->add_option_function<std::vector<std::string>>(
          "POINTS",
          [&arguments](const std::vector<std::string>& files) {
            arguments.sets.push_back({"points", {}});
            for (const std::string& file : files) {
              arguments.sets.back().files.push_back(points_file("POINTS", file));
            }
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
  add_number<double>(
      *command, "--max-frequency", arguments.max_frequency,
      "Up to which frequency, in units of n^(1/D) in the unit box; time grows with its "
      "power of D [2]",
      "F", {.least = 0, .most = 1000, .open_below = true});
  add_directory(*command, "-o,--output", arguments.output,
                "The directory for metrics.json, report.html and the rest; made if need be")
      ->required();
  add_seed_and_threads(*command, arguments.seed, arguments.threads);
  add_flag(*command, "-q,--quiet", arguments.quiet, "Print nothing but errors");
  command->footer(
      "Examples: ccvt analyze run1.npy run2.npy --periodic -o report\n"
      "          ccvt analyze ours.npy --compare theirs=a.csv white=b.csv --periodic -o report");
  return command;
}

}  // namespace ccvt::cli
