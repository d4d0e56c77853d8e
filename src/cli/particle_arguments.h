#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "ccvt/particles.h"

namespace ccvt::cli {

struct SampleArguments;

/// What of a particle load the user has said.
struct ParticleArguments {
  std::optional<double> box_size;
  std::optional<int> repeat;
  std::optional<double> density;
  std::optional<double> redshift;
  std::optional<int> gadget_format;
  bool gas = false;
};

void add_particles(CLI::App& app, ParticleArguments& arguments);

/// Whether the sites of `ccvt sample` go into a file of particles. Throws InvalidInput when they do
/// not and options of particles are given, or when they do and are not in a periodic cube.
bool makes_particles(const SampleArguments& arguments);

ParticleOptions particle_options(const ParticleArguments& arguments);

}  // namespace ccvt::cli
