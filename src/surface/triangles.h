#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "ccvt/surface.h"
#include "surface/sheets.h"

namespace ccvt {

/// Twice the area, along the normal.
inline Eigen::Vector3d area_vector(const Eigen::Matrix3d& corners) {
  return (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0));
}

/// Whether it is a line or a point; not so where numbers are too large to tell.
inline bool has_no_area(const Eigen::Matrix3d& corners) {
  return area_vector(corners) == Eigen::Vector3d::Zero();
}

/// One a column.
inline Eigen::Matrix3d given_corners(const TriangleMesh& mesh, Index triangle) {
  Eigen::Matrix3d corners;
  for (Eigen::Index i = 0; i < 3; ++i) {
    corners.col(i) = mesh.vertices.col(mesh.triangles(i, triangle));
  }
  return corners;
}

/// Around place(corner) of all triangles that have an area, or of all where none has. Vertices of
/// no other triangles may be anywhere.
template <class Place>
Eigen::AlignedBox3d box_around(const TriangleMesh& mesh, const Place& place) {
  Eigen::AlignedBox3d box;
  Eigen::AlignedBox3d box_of_all;
  for (std::ptrdiff_t t = 0; t < mesh.triangles.cols(); ++t) {
    const Eigen::Matrix3d corners = given_corners(mesh, static_cast<Index>(t));
    const bool counts = !has_no_area(corners);
    for (Eigen::Index i = 0; i < 3; ++i) {
      const Eigen::Vector3d at = place(corners.col(i));
      box_of_all.extend(at);
      if (counts) box.extend(at);
    }
  }
  return box.isEmpty() ? box_of_all : box;
}

inline Eigen::AlignedBox3d box_around(const TriangleMesh& mesh) {
  return box_around(mesh, [](const Eigen::Vector3d& corner) { return corner; });
}

/// The triangles of a valid mesh, relative to the middle of the box around them.
class Triangles {
 public:
  explicit Triangles(const TriangleMesh& mesh);

  [[nodiscard]] std::size_t count() const {
    return static_cast<std::size_t>(mesh_.triangles.cols());
  }
  [[nodiscard]] const TriangleMesh& mesh() const { return mesh_; }
  [[nodiscard]] const Eigen::Vector3d& middle() const { return middle_; }
  /// Of the box around them, along each dimension.
  [[nodiscard]] const Eigen::Vector3d& extent() const { return extent_; }

  /// Whether it has an area. By the corners as they are given: seen from the middle, those of a
  /// line far away are rounded, and span an area.
  [[nodiscard]] bool has_area(Index triangle) const {
    return !has_no_area(given_corners(mesh_, triangle));
  }

  /// The corners, one a column.
  [[nodiscard]] Eigen::Matrix3d corners(Index triangle) const;
  /// Their densities.
  [[nodiscard]] Eigen::Vector3d densities(Index triangle) const;
  /// The sum of the corners in the world, each times its share.
  [[nodiscard]] Eigen::Vector3d in_world(Index triangle, const Eigen::Vector3d& shares) const;

 private:
  const TriangleMesh& mesh_;
  Eigen::Vector3d middle_;
  Eigen::Vector3d extent_;
};

/// The point of a triangle that is nearest to another.
struct Foot {
  double squared = 0;      ///< the distance
  Eigen::Vector3d shares;  ///< of the corners: barycentric coordinates
};

/// The nearest of the inside, if a perpendicular leads there, and the three edges. Triangles may be
/// degenerate.
Foot nearest_on_triangle(const Eigen::Matrix3d& corners, const Eigen::Vector3d& from);

}  // namespace ccvt
