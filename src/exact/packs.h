#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "kernels/nearest.h"

namespace ccvt {

/// Positions, one after the other, in packs of so many: see kernels/nearest.h. Zeros fill up the
/// last.
template <std::size_t kPack, class Scalar>
std::vector<Scalar> packs_of(std::span<const double> positions, std::size_t dimension) {
  const std::size_t count = positions.size() / dimension;
  std::vector<Scalar> packs((count + kPack - 1) / kPack * kPack * dimension, Scalar{0});
  for (std::size_t s = 0; s < count; ++s) {
    Scalar* const pack = packs.data() + s / kPack * kPack * dimension;
    for (std::size_t d = 0; d < dimension; ++d) {
      pack[d * kPack + s % kPack] = static_cast<Scalar>(positions[s * dimension + d]);
    }
  }
  return packs;
}

inline std::vector<double> packs_of(std::span<const double> positions, std::size_t dimension) {
  return packs_of<kernels::kPack, double>(positions, dimension);
}

}  // namespace ccvt
