#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>

namespace ccvt::cli {

/// Writes the manual pages of a program and of all its commands, in roff, into a directory.
void write_manual(const CLI::App& app, const std::filesystem::path& directory);

}  // namespace ccvt::cli
