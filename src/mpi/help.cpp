#include "help.h"

#include <algorithm>
#include <vector>

#include "ccvt/io.h"
#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/help.h"
#include "run.h"

namespace ccvt::mpi {
namespace {

struct Change {
  const char* command;
  const char* option;
  std::string text;  ///< empty: the option is for ccvt only
};

const std::vector<Change>& changes() {
  static const std::string parts = ".npy, .fvecs or .bvecs, of which each process reads its part";
  static const std::string preset =
      "The method: a row of the benchmarks' table that starts balanced, such as one-level; threads "
      "are as --threads says [default]";
  static const std::vector<Change> all = {
      {"sample", "--points-out", "Write the points too: .npy"},
      {"sample", "--owners-out", "Write the owner of each point too: .npy"},
      {"sample", "--preset", preset},
      {"tessellate", "POINTS", "Points, a row each: " + parts},
      {"tessellate", "--owners-out", "Write the owner of each point too: .npy"},
      {"tessellate", "--preset", preset},
      {"tessellate", "--capacities",
       "How many points each site owns, summing to the number of points [equal]: .npy, .csv, .txt"},
      {"tessellate", "--masses", ""},
      {"tessellate", "--mass-column", ""},
      {"tessellate", "--mass-method", ""},
      {"tessellate", "--points-per-site", ""},
      {"tessellate", "--shares-out", ""},
      {"quantize", "VECTORS", "Vectors, a row each: " + parts},
      {"quantize", "--codes-out", "Write the code of each vector too: .npy"},
      {"quantize", "--image-blocks", ""},
      {"quantize", "--image-out", ""},
      {"encode", "VECTORS", "Vectors, a row each: " + parts},
      {"encode", "--output", "Where the codes go: .npy"},
      {"volume", "--preset", preset},
      {"volume", "--preview", ""},
  };
  return all;
}

constexpr const char* kForCcvtOnly = "is for ccvt only, not for several processes";
const std::string& balanced() {
  static const std::string text = "Several processes start balanced: in up to " +
                                  std::to_string(kBalancedDimensions) +
                                  " dimensions, and with the presets that do.\n\n";
  return text;
}

std::string example(const std::string& line) { return "Example: mpirun -n 4 ccvt-mpi " + line; }

}  // namespace

void fit_help(CLI::App& app) {
  for (const auto& [command, name, text] : changes()) {
    CLI::Option* const option = app.get_subcommand(command)->get_option(name);
    if (text.empty()) {
      option->group(cli::kHiddenGroup);
      option->check(CLI::Validator([](std::string&) { return std::string(kForCcvtOnly); }, ""));
    } else {
      option->description(text);
    }
  }
  app.get_subcommand("sample")->footer(
      balanced() + example("sample --dim 3 --sites 262144 --periodic -o sites.npy"));
  app.get_subcommand("tessellate")
      ->footer(balanced() + example("tessellate points.npy --sites 1000 -o sites.npy"));
  app.get_subcommand("quantize")
      ->footer("With --method pairwise each process has all vectors.\n\n" +
               example("quantize vectors.fvecs --codewords 1024 -o codebook.npy"));
  app.get_subcommand("encode")->footer(
      example("encode vectors.fvecs --codebook codebook.npy -o codes.npy"));
  app.get_subcommand("volume")->footer(balanced() +
                                       example("volume scan.nii --sites 20000 -o samples.ply"));
}

void require_command(const CLI::App& app, const std::string& word) {
  const auto has = [&](const CLI::App& one) {
    const std::vector<const CLI::App*> commands = cli::commands_of(one);
    return std::any_of(commands.begin(), commands.end(),
                       [&](const CLI::App* command) { return command->get_name() == word; });
  };
  if (has(app) || !has(cli::CommandLine().app())) return;
  throw InvalidInput(word + ": " + kForCcvtOnly);
}

}  // namespace ccvt::mpi
