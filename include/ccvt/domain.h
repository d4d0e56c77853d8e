#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/types.h"

namespace ccvt {

/// An axis-aligned box; both corners have one entry per dimension:
/// `Box{{-1, -2, -3}, {1, 2, 3}}`, or two Eigen vectors in braces.
struct Box {
  Coordinates lower;
  Coordinates upper;

  /// The unit cube [0, 1]^dimension. Throws InvalidInput when `dimension` is negative.
  static Box unit(int dimension) {
    if (dimension < 0) {
      throw InvalidInput("dimension: is " + std::to_string(dimension) + "; must be at least 0");
    }
    return {Coordinates::constant(dimension, 0), Coordinates::constant(dimension, 1)};
  }

  [[nodiscard]] int dimension() const { return static_cast<int>(lower.size()); }
  [[nodiscard]] Eigen::VectorXd extent() const { return upper.eigen() - lower.eigen(); }
  [[nodiscard]] double volume() const { return extent().prod(); }
};

/// Where distances are measured: Euclidean space, or a box that is periodic in all or in some
/// dimensions (a flat torus, a tube, a slab).
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

  /// A box of which some dimensions are periodic: `along` says of each dimension whether the two
  /// faces across it are glued; along the others distances are Euclidean, and faces are borders.
  ///
  ///     ccvt::Domain::periodic(box, {true, true, false})  // a slab
  ///
  /// Throws InvalidInput unless every extent is positive and finite, and `along` has one entry for
  /// each dimension.
  static Domain periodic(Box box, const std::vector<bool>& along);

  /// Whether there is a dimension that is periodic.
  [[nodiscard]] bool is_periodic() const {
    return std::find(periodic_.begin(), periodic_.end(), true) != periodic_.end();
  }
  /// Whether that dimension of the box is; false where there is no box.
  [[nodiscard]] bool is_periodic(int dimension) const {
    return has_box() && periodic_[static_cast<std::size_t>(dimension)];
  }
  /// Whether some dimensions are periodic, and others are not.
  [[nodiscard]] bool is_partly_periodic() const {
    return is_periodic() && std::find(periodic_.begin(), periodic_.end(), false) != periodic_.end();
  }
  [[nodiscard]] bool has_box() const { return box_.dimension() > 0; }
  /// The box; of dimension 0 for plain Euclidean space.
  [[nodiscard]] const Box& box() const { return box_; }

 private:
  Domain(Box box, std::vector<bool> periodic);

  Box box_;
  std::vector<bool> periodic_;  ///< of each dimension of the box
};

}  // namespace ccvt
