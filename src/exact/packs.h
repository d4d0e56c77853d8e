#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "kernels/nearest.h"

namespace ccvt {

/// Positions, one after the other, in packs: see kernels/nearest.h. Zeros fill up the last.
inline std::vector<double> packs_of(std::span<const double> positions, std::size_t dimension) {
  constexpr std::size_t kPack = kernels::kPack;
  const std::size_t count = positions.size() / dimension;
  std::vector<double> packs((count + kPack - 1) / kPack * kPack * dimension, 0.0);
  for (std::size_t s = 0; s < count; ++s) {
    double* const pack = packs.data() + s / kPack * kPack * dimension;
    for (std::size_t d = 0; d < dimension; ++d) {
      pack[d * kPack + s % kPack] = positions[s * dimension + d];
    }
  }
  return packs;
}

}  // namespace ccvt
