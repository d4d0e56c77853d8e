#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace ccvt::cli {

/// What is wrong with the command line, in the words of our other messages, and where help is.
std::string usage_error(const CLI::App& app, const CLI::ParseError& error);

}  // namespace ccvt::cli
