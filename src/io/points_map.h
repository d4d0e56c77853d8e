#pragma once

#include "ccvt/io.h"
#include "ccvt/types.h"

namespace ccvt::io {

/// Points in memory that belongs to the caller of read_points().
template <class Scalar>
using PointsMap = Eigen::Map<Points<Scalar>>;

template <class Scalar>
PointsMap<Scalar> allocate(const detail::Allocation<Scalar>& allocation,
                           const PointsHeader& header) {
  const auto count = static_cast<Index>(header.count);
  return {allocation.allocate(allocation.owner, header.dimension, count), header.dimension, count};
}

}  // namespace ccvt::io
