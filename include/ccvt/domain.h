#pragma once

#include <Eigen/Core>

#include "ccvt/columns.h"
#include "ccvt/export.h"

namespace ccvt {

/// An axis-aligned box; both corners have one entry per dimension:
/// `Box{{-1, -2, -3}, {1, 2, 3}}`, or two Eigen vectors in braces.
struct Box {
  Coordinates lower;
  Coordinates upper;

  /// The unit cube [0, 1]^dimension.
  static Box unit(int dimension) {
    return {Coordinates::constant(dimension, 0), Coordinates::constant(dimension, 1)};
  }

  [[nodiscard]] int dimension() const { return static_cast<int>(lower.size()); }
  [[nodiscard]] Eigen::VectorXd extent() const { return upper.eigen() - lower.eigen(); }
  [[nodiscard]] double volume() const { return extent().prod(); }
};

/// Where distances are measured: Euclidean space, or a periodic box (a flat torus).
///
/// A box also fixes the volume that normalizes the energy; without one, the bounding box of the
/// points is used.
class CCVT_EXPORT Domain {
 public:
  /// Euclidean space of any dimension.
  Domain() = default;

  /// Euclidean space in which all points lie inside `box`.
  /// Throws InvalidInput unless every extent is positive and finite.
  static Domain euclidean(Box box);

  /// The torus obtained by gluing opposite faces of `box`: the squared distance is the sum over
  /// dimensions of min(|d|, extent - |d|)^2.
  /// Throws InvalidInput unless every extent is positive and finite.
  static Domain periodic(Box box);

  [[nodiscard]] bool is_periodic() const { return periodic_; }
  [[nodiscard]] bool has_box() const { return box_.dimension() > 0; }
  /// The box; of dimension 0 for plain Euclidean space.
  [[nodiscard]] const Box& box() const { return box_; }

 private:
  Domain(Box box, bool periodic);

  Box box_;
  bool periodic_ = false;
};

}  // namespace ccvt
