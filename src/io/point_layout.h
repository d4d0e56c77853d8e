#pragma once

#include <algorithm>
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

/// Of the rows of a file, those that `options` ask for: begin.. to end - 1.
struct RowRange {
  RowRange(const ReadOptions& options, std::uint64_t count)
      : begin(std::min(options.first_row, count)), end(std::clamp(options.end_row, begin, count)) {}
  [[nodiscard]] std::uint64_t size() const { return end - begin; }
  std::uint64_t begin;
  std::uint64_t end;
};

}  // namespace ccvt::io
