#pragma once

#include <hwy/cache_control.h>

#include <algorithm>
#include <array>

#include "ccvt/types.h"

namespace ccvt::kernels {

/// The kRows points from the k-th on, the last in place of those that are missing. Those that
/// follow are fetched: they are scattered, and little is read of each.
template <Index kRows, class Scalar>
HWY_INLINE std::array<const Scalar*, kRows> rows_from(const Scalar* const* points, Index k,
                                                      Index count, int dimension) {
  constexpr int kLine = 64 / sizeof(Scalar);
  constexpr int kPrefetched = 16 * kLine;
  std::array<const Scalar*, kRows> row{};
  for (Index r = 0; r < kRows; ++r) row.data()[r] = points[std::min(k + r, count - 1)];
  for (Index r = k + kRows; r < std::min(k + 2 * kRows, count); ++r) {
    for (int d = 0; d < std::min(dimension, kPrefetched); d += kLine) hwy::Prefetch(points[r] + d);
  }
  return row;
}

}  // namespace ccvt::kernels
