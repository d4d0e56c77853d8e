#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <utility>

#include "geometry/coordinate_range.h"
#include "parallel/together.h"

namespace ccvt {

/// Around the points of all ranks.
template <class Scalar>
Box box_of_all(Ranks& ranks, const PointsView<Scalar>& own, const Arena& arena) {
  ByteWriter message;
  if (own.count > 0) {
    const CoordinateRange<Scalar> range = coordinate_range(own, arena);
    message.put(std::span(std::as_const(range.lower)));
    message.put(std::span(std::as_const(range.upper)));
  }
  CoordinateRange<Scalar> all;
  for (const Ranks::Bytes& bytes : ranks.gather(message.bytes)) {
    if (bytes.empty()) continue;
    CoordinateRange<Scalar> range;
    range.lower.resize(static_cast<std::size_t>(own.dimension));
    range.upper.resize(range.lower.size());
    ByteReader reader(bytes);
    reader.get(std::span(range.lower));
    reader.get(std::span(range.upper));
    if (all.lower.empty()) all = range;
    for (std::size_t d = 0; d < range.lower.size(); ++d) {
      all.lower[d] = std::min(all.lower[d], range.lower[d]);
      all.upper[d] = std::max(all.upper[d], range.upper[d]);
    }
  }
  Box box = Box::unit(own.dimension);
  std::copy(all.lower.begin(), all.lower.end(), box.lower.data());
  std::copy(all.upper.begin(), all.upper.end(), box.upper.data());
  return box;
}

}  // namespace ccvt
