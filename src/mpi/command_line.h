#pragma once

#include <CLI/CLI.hpp>

#include "cli/arguments.h"

namespace ccvt::mpi {

/// All commands of ccvt-mpi with their options, and the arguments that these fill.
struct CommandLine {
  template <class Arguments>
  struct Command {
    Arguments arguments;
    const CLI::App* command = nullptr;
  };

  CommandLine();

  CLI::App app;
  Command<cli::SampleArguments> sample;
  Command<cli::TessellateArguments> tessellate;
  Command<cli::QuantizeArguments> quantize;
  Command<cli::EncodeArguments> encode;
  Command<cli::VolumeArguments> volume;
};

}  // namespace ccvt::mpi
