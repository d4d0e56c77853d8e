#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>

#include "cli/arguments.h"

namespace ccvt::cli {

struct ThinArguments : CommonArguments {
  std::filesystem::path points;
  ReadOptions reading;                  ///< of the points
  Index sites = 0;                      ///< 0: by the ratio
  double ratio = 0;                     ///< points to sites; 0: by the sites
  std::optional<double> normal_weight;  ///< where none is given, the usual one
  bool equal_counts = false;            ///< not each point for the nearest chosen one
  std::filesystem::path indices_out;
  std::filesystem::path owners_out;
};

CLI::App* add_thin(CLI::App& app, ThinArguments& arguments);
int run_thin(const ThinArguments& arguments);

}  // namespace ccvt::cli
