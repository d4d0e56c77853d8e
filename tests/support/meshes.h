#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "ccvt/surface.h"

/// Surfaces given by formula, and what their samples are measured by.
namespace ccvt::test {

/// A mesh of columns x rows quads, two triangles each, of place(u, v), u and v from 0 to 1. Where a
/// direction is closed, its last vertices are its first ones.
inline TriangleMesh patch(Index columns, Index rows, bool closed_u, bool closed_v,
                          const std::function<Eigen::Vector3d(double, double)>& place) {
  const Index wide = columns + (closed_u ? 0 : 1);
  const Index high = rows + (closed_v ? 0 : 1);
  TriangleMesh mesh;
  mesh.vertices = Columns<double>(3, wide * high);
  mesh.triangles = Columns<Index>(3, 2 * columns * rows);
  for (Index j = 0; j < high; ++j) {
    for (Index i = 0; i < wide; ++i) {
      mesh.vertices.eigen().col(j * wide + i) = place(1.0 * i / columns, 1.0 * j / rows);
    }
  }
  const auto number = [&](Index i, Index j) { return j % high * wide + i % wide; };
  for (Index j = 0; j < rows; ++j) {
    for (Index i = 0; i < columns; ++i) {
      const Index a = number(i, j);
      const Index b = number(i + 1, j);
      const Index c = number(i + 1, j + 1);
      const Index d = number(i, j + 1);
      auto triangles = mesh.triangles.eigen();
      const Eigen::Index t = 2 * (Eigen::Index{j} * columns + i);
      triangles.col(t) << a, b, c;
      triangles.col(t + 1) << a, c, d;
    }
  }
  return mesh;
}

/// A square of side 1 at height z, facing up.
inline TriangleMesh square(Index cells, double z = 0) {
  return patch(cells, cells, false, false,
               [z](double u, double v) { return Eigen::Vector3d(u, v, z); });
}

/// Radius 1, with triangles without area at the poles.
inline TriangleMesh sphere(Index around, Index up) {
  return patch(around, up, true, false, [](double u, double v) {
    const double a = 2 * std::numbers::pi * u;
    const double b = std::numbers::pi * v;
    return Eigen::Vector3d(std::sin(b) * std::cos(a), std::sin(b) * std::sin(a), -std::cos(b));
  });
}

/// Around the z axis; the tube has the radius `thin`.
inline TriangleMesh torus(Index around, Index across, double thin = 0.4) {
  return patch(around, across, true, true, [thin](double u, double v) {
    const double a = 2 * std::numbers::pi * u;
    const double b = 2 * std::numbers::pi * v;
    const double r = 1 + thin * std::cos(b);
    return Eigen::Vector3d(r * std::cos(a), r * std::sin(a), thin * std::sin(b));
  });
}

/// All triangles facing the other way.
inline TriangleMesh turned(TriangleMesh mesh) {
  mesh.triangles.eigen().row(1).swap(mesh.triangles.eigen().row(2));
  return mesh;
}

/// Both meshes.
inline TriangleMesh together(const TriangleMesh& a, const TriangleMesh& b) {
  TriangleMesh mesh;
  const auto before = a.vertices.cols();
  mesh.vertices = Columns<double>(3, before + b.vertices.cols());
  mesh.vertices.eigen() << a.vertices.eigen(), b.vertices.eigen();
  mesh.triangles = Columns<Index>(3, a.triangles.cols() + b.triangles.cols());
  mesh.triangles.eigen() << a.triangles.eigen(),
      (b.triangles.eigen().array() + static_cast<Index>(before)).matrix();
  return mesh;
}

inline Eigen::Matrix3d corners_of(const TriangleMesh& mesh, Index triangle) {
  Eigen::Matrix3d corners;
  for (Eigen::Index i = 0; i < 3; ++i) {
    corners.col(i) = mesh.vertices.col(mesh.triangles(i, triangle));
  }
  return corners;
}

inline double area_of(const TriangleMesh& mesh, Index triangle) {
  const Eigen::Matrix3d c = corners_of(mesh, triangle);
  const Eigen::Vector3d a = c.col(1) - c.col(0);
  const Eigen::Vector3d b = c.col(2) - c.col(0);
  return Eigen::Vector3d(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                         a[0] * b[1] - a[1] * b[0])
             .norm() /
         2;
}

/// The smallest distance of two samples that `counts` says are to be kept apart, as a share of the
/// distance in a hexagonal lattice as dense as they are, sqrt(2 A / (sqrt(3) n)).
inline double smallest_distance(
    const SurfaceSamples& samples,
    const std::function<bool(Eigen::Index, Eigen::Index)>& counts = {}) {
  double least = std::numeric_limits<double>::infinity();
  const auto sites = samples.sites.eigen();
  for (Eigen::Index a = 0; a < sites.cols(); ++a) {
    for (Eigen::Index b = 0; b < a; ++b) {
      if (counts && !counts(a, b)) continue;
      least = std::min(least, (sites.col(a) - sites.col(b)).squaredNorm());
    }
  }
  const double count = static_cast<double>(sites.cols());
  return std::sqrt(least) / std::sqrt(2 * samples.area / (std::sqrt(3.0) * count));
}

}  // namespace ccvt::test
