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
  std::vector<std::pair<const CLI::App*, std::function<int()>>> commands_;
};

}  // namespace ccvt::cli
