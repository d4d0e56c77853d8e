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
  static const std::string columns = "Which columns are coordinates, by number from 1 [all]";
  static const std::vector<Change> all = {
      {"sample", "--points-out", "Write the points too: .npy"},
      {"sample", "--owners-out", "Write the owner of each point too: .npy"},
      {"sample", "--preset", preset},
      {"tessellate", "POINTS", "Points, a row each: " + parts},
      {"tessellate", "--columns", columns},
      {"tessellate", "--periodic", "Opposite faces of --box are one"},
      {"tessellate", "--box",
       "The box that holds the points: all lower bounds, then all upper bounds"},
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
      {"quantize", "--columns", columns},
      {"quantize", "--codes-out", "Write the code of each vector too: .npy"},
      {"quantize", "--image-blocks", ""},
      {"quantize", "--image-out", ""},
      {"encode", "VECTORS", "Vectors, a row each: " + parts},
      {"encode", "--columns", columns},
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
                                  " dimensions, and with the presets that do.";
  return text;
}

/// Ends a command's help with an example, and what else there is to know.
void end(CLI::App& app, const std::string& command, const std::string& arguments,
         const std::string& notes = "") {
  app.get_subcommand(command)->footer("Example: mpirun -n 4 ccvt-mpi " + command + " " + arguments +
                                      (notes.empty() ? "" : "\n\n" + notes));
}

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
  end(app, "sample", "--dim 3 --sites 262144 --periodic -o sites.npy", balanced());
  end(app, "tessellate", "points.npy --sites 1000 -o sites.npy", balanced());
  end(app, "quantize", "vectors.fvecs --codewords 1024 -o codebook.npy",
      "With --method pairwise each process has all vectors.");
  end(app, "encode", "vectors.fvecs --codebook codebook.npy -o codes.npy");
  end(app, "volume", "scan.nii --sites 20000 -o samples.ply", balanced());
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
