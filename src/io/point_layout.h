#pragma once

#include <cstddef>
#include <cstdint>

#include "ccvt/io.h"

namespace ccvt::io {

/// Where the points of a file lie in it, all of them as numbers of this machine.
struct PointLayout {
  ScalarType scalar = ScalarType::float32;
  int dimension = 0;
  Index count = 0;
  std::uint64_t offset = 0;   ///< bytes before the first coordinate
  std::ptrdiff_t stride = 0;  ///< from point to point, in coordinates
};

}  // namespace ccvt::io
