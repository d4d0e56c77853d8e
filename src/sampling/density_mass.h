#pragma once

#include <span>

#include "ccvt/density.h"
#include "ccvt/ranks.h"
#include "parallel/arena.h"

namespace ccvt {

/// The integral of a density over the world. Throws InvalidInput for the values that
/// sample_density() refuses.
double density_mass(const DensityGrid& grid, const Arena& arena);
/// The same, on all ranks.
double density_mass(Ranks& ranks, const DensityLayers& density, const Arena& arena);
/// The same, from the masses of the parts of the grid, in units of a cell's.
double integral(const DensityGrid& grid, std::span<const double> masses);

}  // namespace ccvt
