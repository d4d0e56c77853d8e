#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

namespace ccvt::cli {

/// The manual page of a program, or of one of its commands, as roff for man.
std::string manual_page(const CLI::App& app, const CLI::App* command);

/// Writes the pages of a program and of all its commands into a directory.
void write_manual(const CLI::App& app, const std::filesystem::path& directory);

}  // namespace ccvt::cli
