#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace ccvt::cli {

/// A manual page in roff: of the whole program (`command` empty), or of one command.
std::string manual_page(const CLI::App& app, const CLI::App* command);

}  // namespace ccvt::cli
