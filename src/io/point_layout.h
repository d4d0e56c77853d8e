#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>

#include "ccvt/io.h"
#include "io/input_file.h"

namespace ccvt::io {

/// Where the points of a file lie in it, all of them as numbers of this machine.
struct PointLayout {
  ScalarType scalar = ScalarType::float32;
  int dimension = 0;
  std::uint64_t count = 0;
  std::uint64_t offset = 0;   ///< bytes before the first coordinate
  std::ptrdiff_t stride = 0;  ///< from point to point, in coordinates
};

/// Fails where more points are to be read than Index counts: of several ranks each reads its part.
inline void require_countable(const InputFile& file, std::uint64_t points) {
  if (points <= std::uint64_t{std::numeric_limits<Index>::max()}) return;
  file.fail("has " + std::to_string(points) +
            " points to be read; at most 2147483647 are supported at once");
}

/// Of the rows of a file, those that `options` ask for: begin.. to end - 1.
struct RowRange {
  RowRange(const ReadOptions& options, std::uint64_t count)
      : begin(std::min(options.first_row, count)), end(std::clamp(options.end_row, begin, count)) {}
  [[nodiscard]] std::uint64_t size() const { return end - begin; }
  std::uint64_t begin;
  std::uint64_t end;
};

}  // namespace ccvt::io
