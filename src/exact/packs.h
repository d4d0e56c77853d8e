#pragma once

#include <algorithm>
#include <array>
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

/// Squared distances from positions to all of packs.
class PackedDistances {
 public:
  /// Calls visit(k, squared) for each k of `which`, which is at at(k), in their order; on a torus
  /// when `extent` is given. Several at a time are measured, so that packs are read once for them.
  template <class Which, class At, class Visit>
  void for_each(std::span<Which> which, const At& at, std::span<const double> packs, int dimension,
                const double* extent, const Visit& visit) {
    const std::size_t width = packs.size() / static_cast<std::size_t>(dimension);
    squared_.resize(kTogether * width);
    std::array<const double*, kTogether> query{};
    std::array<double*, kTogether> out{};
    for (std::size_t begin = 0; begin < which.size(); begin += kTogether) {
      const auto some = which.subspan(begin, std::min(kTogether, which.size() - begin));
      for (std::size_t k = 0; k < some.size(); ++k) {
        query.data()[k] = at(some[k]);
        out.data()[k] = squared_.data() + k * width;
      }
      kernels::squared_distances(query.data(), static_cast<Index>(some.size()), packs.data(),
                                 static_cast<Index>(width) / kernels::kPack, dimension, extent,
                                 out.data());
      for (std::size_t k = 0; k < some.size(); ++k) {
        visit(some[k], std::span<const double>(squared_).subspan(k * width, width));
      }
    }
  }

 private:
  static constexpr std::size_t kTogether = 4;
  std::vector<double> squared_;
};

}  // namespace ccvt
