// Faces of meshes that are no triangles.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "ccvt/surface.h"
#include "random.h"
#include "support/files.h"

using ccvt::Index;
using ccvt::read_mesh;
using ccvt::TriangleMesh;
using namespace ccvt::test;

namespace {

using Polygon = std::vector<Eigen::Vector3d>;

/// An OBJ file whose faces come before their vertices; the first corner is any.
std::string obj_of(const Polygon& polygon, std::size_t first) {
  std::ostringstream text;
  text.precision(17);
  text << "f";
  for (std::size_t k = 0; k < polygon.size(); ++k) text << ' ' << 1 + (first + k) % polygon.size();
  for (const Eigen::Vector3d& x : polygon) text << "\nv " << x.transpose();
  return text.str() + "\n";
}

/// Twice the area, along the normal.
Eigen::Vector3d normal_of(const Polygon& polygon) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < polygon.size(); ++k) {
    sum += polygon[k].cross(polygon[(k + 1) % polygon.size()]);
  }
  return sum;
}

/// Triangles that all face as the polygon does, and have its area together, lie on its side of the
/// border.
void check_filled(const Polygon& polygon) {
  const TemporaryDirectory directory;
  const Eigen::Vector3d normal = normal_of(polygon);
  for (std::size_t first = 0; first < polygon.size(); ++first) {
    CAPTURE(first);
    put(directory / "m.obj", obj_of(polygon, first));
    const TriangleMesh mesh = read_mesh(directory / "m.obj");
    REQUIRE(mesh.triangles.cols() == static_cast<Index>(polygon.size()) - 2);
    double sum = 0;
    bool faces_back = false;
    for (Index t = 0; t < mesh.triangles.cols(); ++t) {
      const auto corner = [&](int k) -> Eigen::Vector3d {
        return mesh.vertices.col(mesh.triangles(k, t));
      };
      const double along = (corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(normal);
      faces_back = faces_back || along < -1e-12 * normal.squaredNorm();
      sum += std::abs(along);
    }
    CHECK(!faces_back);
    CHECK(sum == doctest::Approx(normal.squaredNorm()).epsilon(1e-9));
  }
}

Polygon turned(const std::vector<Eigen::Vector2d>& flat, ccvt::Random& random) {
  const auto any = [&] { return random.uniform() - 0.5; };
  const Eigen::Matrix3d rotation =
      Eigen::Quaterniond(any(), any(), any(), any()).normalized().toRotationMatrix();
  Polygon polygon;
  for (const Eigen::Vector2d& x : flat) {
    polygon.push_back(rotation * Eigen::Vector3d(x.x(), x.y(), 3));
  }
  return polygon;
}

}  // namespace

TEST_SUITE_BEGIN("mesh");

TEST_CASE("concave faces are filled, and no more than that") {
  ccvt::Random random(1, 1);
  // A square with a dent, whose fan around (0, 0) would have 14 in place of 10.
  check_filled(turned({{0, 0}, {4, 0}, {4, 4}, {2, 1}, {0, 4}}, random));
  // A comb, with corners on straight edges.
  check_filled(turned({{0, 0},
                       {2, 0},
                       {5, 0},
                       {5, 3},
                       {4, 3},
                       {4, 1},
                       {3, 1},
                       {3, 3},
                       {2, 3},
                       {2, 1},
                       {1, 1},
                       {1, 3},
                       {0, 3}},
                      random));
  // A square with a square hole, to which a bridge leads and back.
  check_filled(turned(
      {{0, 0}, {4, 0}, {4, 4}, {0, 4}, {0, 0}, {1, 1}, {1, 3}, {3, 3}, {3, 1}, {1, 1}}, random));
  // A border that touches itself from inside.
  check_filled(turned({{0.1, 2}, {0, 0}, {4, 0}, {4, 4}, {3, 4}, {0, 0}, {1, 4}, {0, 4}}, random));
  // Corners on straight edges, which rounding moves off these.
  for (int trial = 0; trial < 300; ++trial) {
    CAPTURE(trial);
    check_filled(turned({{0, 0},
                         {1, 0},
                         {2, 0},
                         {2, 1},
                         {2, 2},
                         {1, 2},
                         {1, 3},
                         {1, 4},
                         {0, 4},
                         {0, 3},
                         {0, 2},
                         {0, 1}},
                        random));
  }
  for (int trial = 0; trial < 50; ++trial) {
    CAPTURE(trial);
    std::vector<Eigen::Vector2d> star;
    const int corners = 4 + static_cast<int>(random.below(20));
    for (int k = 0; k < corners; ++k) {
      const double angle = 2 * std::numbers::pi * (k + 0.8 * random.uniform()) / corners;
      star.push_back((0.1 + random.uniform()) * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
    }
    if (trial % 2 == 0) std::reverse(star.begin(), star.end());
    check_filled(turned(star, random));
  }
}

TEST_CASE("faces that a fan fills become fans, and so do those that cross themselves") {
  const TemporaryDirectory directory;
  const std::string square = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";
  const std::string bow = "v 0 0 0\nv 2 2 0\nv 2 0 0\nv 0 2 0\n";
  for (const std::string& vertices : {square, bow}) {
    put(directory / "m.obj", vertices + "f 1 2 3 4\n");
    const Eigen::Matrix<Index, 3, 2> fan{{0, 0}, {1, 2}, {2, 3}};
    CHECK(read_mesh(directory / "m.obj").triangles == fan);
  }
}

TEST_SUITE_END();
