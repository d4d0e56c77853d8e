#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cli/arguments.h"
#include "cli/surface.h"
#include "cli/thin_arguments.h"

namespace ccvt::cli {

using Commands = std::vector<std::pair<const CLI::App*, std::function<int()>>>;

/// Of a program with commands: what all have, but for its examples.
void set_up(CLI::App& app);
/// Parses the line and runs the command that it names; the exit status. Help and version are handed
/// to `show`. Throws InvalidInput for whatever is wrong with the line, and what the command throws.
int parse_and_run(CLI::App& app, const Commands& commands, int argc, const char* const* argv,
                  const std::function<void(const std::string&)>& show);

/// All commands with their options, and the arguments that these fill.
class CommandLine {
 public:
  CommandLine();

  /// Parses the line and runs the command that it names; the exit status. Prints help and version.
  /// Throws InvalidInput for whatever is wrong with the line, and what the command throws.
  int run(int argc, const char* const* argv);

  [[nodiscard]] const CLI::App& app() const { return app_; }

 private:
  CLI::App app_;
  SampleArguments sample_;
  TessellateArguments tessellate_;
  StippleArguments stipple_;
  AnalyzeArguments analyze_;
  QuantizeArguments quantize_;
  EncodeArguments encode_;
  VolumeArguments volume_;
  SurfaceArguments surface_;
  ThinArguments thin_;
  Commands commands_;
};

}  // namespace ccvt::cli
