#include "cli/command_line.h"

#include <algorithm>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "cli/argument_kinds.h"
#include "cli/commands.h"
#include "cli/help.h"
#include "cli/streams.h"
#include "cli/usage_error.h"
#include "cli/version_text.h"

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
    "  curl -s URL | ccvt tessellate - --sites 100 -o - | sort -g\n"
    "\n"
    "A FILE may be -, standard input or output, as csv, or npy:- and so on: see a command's help.\n"
    "Outputs appear together, complete, when all is done; until then the old files stay.\n"
    "Exit status: 0 done, 1 failure, such as a full disk, 2 bad usage or input, or an output\n"
    "that may not be written, 130 stopped by Ctrl-C. That ends reading, analyze and encode at\n"
    "once, and nothing is written; else the tessellation or codebook reached so far is written,\n"
    "unless a second Ctrl-C comes, which quits at once.";

}  // namespace

void set_up(CLI::App& app) {
  app.set_version_flag("-V,--version", version_text,
                       "Print what this program is made of, and exit");
  app.set_help_flag("-h,--help", "Print this help, and exit");
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpFormatter>());
}

int parse_and_run(CLI::App& app, const Commands& commands, int argc, const char* const* argv,
                  const std::function<void(const std::string&)>& show) {
  std::vector<std::string> words = reversed_arguments(argc, argv);
  if (!words.empty() && words.back() == "help") {
    words.pop_back();
    // What is no command is left to be refused.
    const std::vector<const CLI::App*> all = commands_of(app);
    const auto is_meant = [&](const CLI::App* one) { return one->get_name() == words.back(); };
    if (words.empty() || std::any_of(all.begin(), all.end(), is_meant)) {
      words.insert(words.begin(), "--help");
    }
  }
  try {
    app.parse(std::move(words));
  } catch (const CLI::Success& success) {  // help, version
    std::ostringstream text;
    const int status = app.exit(success, text);
    show(text.str());
    return status;
  } catch (const CLI::ParseError& error) {
    throw InvalidInput(usage_error(app, error));
  }
  const auto given = std::find_if(commands.begin(), commands.end(),
                                  [](const auto& command) { return command.first->parsed(); });
  return given->second();
}

CommandLine::CommandLine()
    : app_("Capacity-constrained Voronoi tessellation in any dimension", "ccvt") {
  set_up(app_);
  app_.footer(kExamples);
  commands_ = {
      {add_sample(app_, sample_), [&] { return run_sample(sample_); }},
      {add_tessellate(app_, tessellate_), [&] { return run_tessellate(tessellate_); }},
      {add_stipple(app_, stipple_), [&] { return run_stipple(stipple_); }},
      {add_volume(app_, volume_), [&] { return run_volume(volume_); }},
      {add_surface(app_, surface_), [&] { return run_surface(surface_); }},
      {add_thin(app_, thin_), [&] { return run_thin(thin_); }},
      {add_analyze(app_, analyze_), [&] { return run_analyze(analyze_); }},
      {add_quantize(app_, quantize_), [&] { return run_quantize(quantize_); }},
      {add_encode(app_, encode_), [&] { return run_encode(encode_); }},
  };
}

int CommandLine::run(int argc, const char* const* argv) {
  return parse_and_run(app_, commands_, argc, argv, print);
}

}  // namespace ccvt::cli
