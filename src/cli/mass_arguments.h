#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>

#include "ccvt/types.h"
#include "ccvt/weighted.h"

namespace ccvt::cli {

/// Points with masses.
struct MassArguments {
  std::filesystem::path file;  ///< empty: none
  std::string column;          ///< of the file of points; empty: none
  std::optional<MassMethod> method;
  std::optional<Index> points_per_site;
  std::filesystem::path shares_out;  ///< empty: none

  [[nodiscard]] bool given() const { return !file.empty() || !column.empty(); }
};

/// --masses and what goes with it.
void add_masses(CLI::App& app, MassArguments& target);

}  // namespace ccvt::cli
