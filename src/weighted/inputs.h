#pragma once

#include <span>
#include <vector>

#include "ccvt/weighted.h"

namespace ccvt {

/// Masses and capacities that have been checked, times a power of two that makes the mean mass of
/// the points that have any about 1, so that neither the largest nor the smallest leave the range
/// of double in products.
struct MassInputs {
  std::vector<double> masses;
  std::vector<double> capacities;
  double total = 0;
  double scale = 1;  ///< masses given are these over it

  /// Throws InvalidInput as tessellate_masses() does.
  MassInputs(std::span<const double> given, std::size_t points, Index sites,
             const MassOptions& options);
};

}  // namespace ccvt
