#pragma once

#include <Eigen/Core>

#include "ccvt/types.h"

namespace ccvt {

/// A view of points as Eigen sees it.
template <class Scalar>
Eigen::Map<const Points<Scalar>, Eigen::Unaligned, Eigen::OuterStride<>> as_matrix(
    PointsView<Scalar> points) {
  return {points.data, points.dimension, points.count, Eigen::OuterStride<>(points.stride)};
}

}  // namespace ccvt
