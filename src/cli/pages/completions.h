#pragma once

#include <CLI/CLI.hpp>
#include <string>

/// What a shell must know to complete a line of `ccvt`: commands, options, and where files go.
namespace ccvt::cli {

std::string bash_completion(const CLI::App& app);
std::string zsh_completion(const CLI::App& app);
std::string fish_completion(const CLI::App& app);

}  // namespace ccvt::cli
