#pragma once

#include <CLI/CLI.hpp>

#include "cli/arguments.h"

/// Each adds a command whose options fill `arguments`, which must outlive the App.
namespace ccvt::cli {

CLI::App* add_sample(CLI::App& app, SampleArguments& arguments);
CLI::App* add_tessellate(CLI::App& app, TessellateArguments& arguments);
CLI::App* add_stipple(CLI::App& app, StippleArguments& arguments);
CLI::App* add_volume(CLI::App& app, VolumeArguments& arguments);
CLI::App* add_analyze(CLI::App& app, AnalyzeArguments& arguments);
CLI::App* add_quantize(CLI::App& app, QuantizeArguments& arguments);
CLI::App* add_encode(CLI::App& app, EncodeArguments& arguments);

}  // namespace ccvt::cli
