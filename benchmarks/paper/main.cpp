// ccvt-bench: the paper's table and figures, measured here.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "ccvt/io.h"
#include "ccvt/types.h"
#include "paper/experiments.h"

namespace {

using ccvt::bench::Scale;
namespace fs = std::filesystem;

struct Experiment {
  const char* name;
  const char* description;
  void (*run)(const Scale&, const fs::path&);
};
constexpr Experiment kExperiments[] = {
    {"table1", "Table 1: every row, the paper's and ours, on four sizes", ccvt::bench::table1},
    {"clusters", "Figure 2: how many pairs there are in a batch", ccvt::bench::clusters},
    {"quality", "Figure 4: spectra by points per site and kind of points", ccvt::bench::quality},
    {"scaling", "Time against sites, points per site, threads, dimensions", ccvt::bench::scaling},
    {"growth", "Time and order with many points per site", ccvt::bench::growth},
    {"parallel", "Threads: phase by phase, and predicted for more of them", ccvt::bench::parallel},
    {"search", "Inverted lists: recall against vectors scanned", ccvt::bench::search},
};

struct Arguments {
  Scale scale;
  fs::path directory;
};

void add_arguments(CLI::App& command, Arguments& arguments) {
  command
      .add_option("-o,--output", arguments.directory,
                  "The directory to write into; made if need be")
      ->required()
      ->type_name("DIR");
  auto* const quick =
      command.add_flag("--quick", arguments.scale.quick, "Small problems: does all of it work?");
  command.add_flag("--long", arguments.scale.is_long, "No run is too long")->excludes(quick);
  command.add_option("--repetitions", arguments.scale.repetitions, "Of each run [3]")
      ->check(CLI::Range(1, 1000))
      ->type_name("R");
  command.add_option("--threads", arguments.scale.threads, "At most; 0: one per processor [0]")
      ->check(CLI::Range(0, 4096))
      ->type_name("T");
  command
      .add_option("--budget", arguments.scale.budget,
                  "Seconds; rows of table1 that would take longer are estimated [30]")
      ->check(CLI::Range(0.1, 1e6))
      ->type_name("S");
}

void add_search_files(CLI::App& command, ccvt::bench::SearchFiles& files) {
  auto* const vectors =
      command
          .add_option("--vectors", files.vectors, "To search: .npy, .fvecs, .bvecs; else clouds")
          ->excludes(command.get_option("--quick"))
          ->excludes(command.get_option("--long"))
          ->check(CLI::ExistingFile)
          ->type_name("FILE");
  auto* const queries = command.add_option("--queries", files.queries, "To search for")
                            ->needs(vectors)
                            ->type_name("FILE");
  vectors->needs(queries);
  command.add_option("--codewords", files.codewords, "Lists, of these vectors [256]")
      ->needs(vectors)
      ->check(CLI::PositiveNumber)
      ->type_name("K");
}

void make_directory(const fs::path& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw ccvt::IoError(path.string() + ": cannot be made: " + error.message());
  // Before hours of work: can it be written to?
  const fs::path probe = path / "report.md";
  if (!fs::exists(probe)) {
    ccvt::write_text(probe, "");
    fs::remove(probe, error);
  }
}

int run(int argc, char** argv) {
  CLI::App app("The paper's table and figures, measured here", "ccvt-bench");
  app.require_subcommand(1);
  app.footer("Example: ccvt-bench all -o results; the tables are then in results/report.md.");
  Arguments arguments;
  for (const Experiment& experiment : kExperiments) {
    CLI::App* const command = app.add_subcommand(experiment.name, experiment.description);
    add_arguments(*command, arguments);
    const std::string name = experiment.name;
    if (name == "search") add_search_files(*command, arguments.scale.search);
    if (name != "table1" && name != "growth" && name != "parallel") continue;
    command->add_option("--only", arguments.scale.only, "One size, such as 1024x256")
        ->type_name("SIZE");
  }
  add_arguments(*app.add_subcommand("all", "All of these, and the report"), arguments);
  CLI::App* const report = app.add_subcommand("report", "Tables and plots of what was measured");
  report->add_option("DIR", arguments.directory, "Where the measurements are")->required();
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    const std::vector<std::string> unknown = app.remaining(true);
    const std::string wrong =
        unknown.empty() ? error.what() : "unknown argument '" + unknown[0] + "'";
    throw ccvt::InvalidInput(wrong + "; see ccvt-bench --help");
  }
  if (!report->parsed()) {
    if (arguments.scale.quick) arguments.scale.repetitions = 1;
    make_directory(arguments.directory);
    for (const Experiment& experiment : kExperiments) {
      if (app.got_subcommand(experiment.name) || app.got_subcommand("all")) {
        experiment.run(arguments.scale, arguments.directory);
      }
    }
  }
  std::fputs(ccvt::bench::report(arguments.directory).c_str(), stdout);
  return 0;
}

int fail(const std::string& message, int status) {
  std::fprintf(stderr, "ccvt-bench: error: %s\n", message.c_str());
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const ccvt::InvalidInput& error) {
    return fail(error.what(), 2);
  } catch (const ccvt::IoError& error) {
    return fail(error.what(), 2);
  } catch (const std::exception& error) {
    return fail(error.what(), 1);
  }
}
