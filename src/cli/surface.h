#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>

#include "ccvt/surface.h"
#include "cli/arguments.h"

namespace ccvt::cli {

struct SurfaceArguments : CommonArguments {
  std::filesystem::path mesh;
  Index sites = 0;
  Index points_per_site = 256;
  std::string density;  ///< a property of the vertices; empty: none
  double normal_weight = SurfaceOptions{}.normal_weight;
  std::filesystem::path preview;  ///< empty: none
  int up = 2;                     ///< the dimension that points up in it
};

CLI::App* add_surface(CLI::App& app, SurfaceArguments& arguments);

/// Runs the command and returns the exit status. Throws InvalidInput, IoError and std::bad_alloc.
int run_surface(const SurfaceArguments& arguments);

}  // namespace ccvt::cli
