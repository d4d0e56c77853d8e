#pragma once

#include "ccvt/density.h"
#include "parallel/arena.h"

namespace ccvt {

/// The integral of a density over the world. Throws InvalidInput for the values that
/// sample_density() refuses.
double density_mass(const DensityGrid& grid, const Arena& arena);

}  // namespace ccvt
