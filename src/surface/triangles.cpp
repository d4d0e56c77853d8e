#include "surface/triangles.h"

#include <algorithm>
#include <cmath>

namespace ccvt {

Triangles::Triangles(const TriangleMesh& mesh) : mesh_(mesh) {
  const Eigen::AlignedBox3d box = box_around(mesh);
  middle_ = box.min() + box.sizes() / 2;
  extent_ = box.sizes();
}

Eigen::Matrix3d Triangles::corners(Index triangle) const {
  return given_corners(mesh_, triangle).colwise() - middle_;
}

Eigen::Vector3d Triangles::densities(Index triangle) const {
  if (mesh_.density.empty()) return Eigen::Vector3d::Ones();
  Eigen::Vector3d result;
  for (Eigen::Index i = 0; i < 3; ++i) {
    result[i] = mesh_.density[static_cast<std::size_t>(mesh_.triangles(i, triangle))];
  }
  return result;
}

Eigen::Vector3d Triangles::in_world(Index triangle, const Eigen::Vector3d& shares) const {
  Eigen::Vector3d result = Eigen::Vector3d::Zero();
  for (Eigen::Index i = 0; i < 3; ++i) {
    result += shares[i] * mesh_.vertices.col(mesh_.triangles(i, triangle));
  }
  return result;
}

Foot nearest_on_triangle(const Eigen::Matrix3d& corners, const Eigen::Vector3d& from) {
  Foot best;
  best.squared = INFINITY;
  const auto offer = [&](const Eigen::Vector3d& shares) {
    const double squared = (corners * shares - from).squaredNorm();
    if (squared < best.squared) best = {squared, shares};
  };
  const Eigen::Vector3d normal = area_vector(corners);
  const double area = normal.squaredNorm();
  if (area > 0) {
    const Eigen::Vector3d along = from - corners.col(0);
    const double second = along.cross(corners.col(2) - corners.col(0)).dot(normal) / area;
    const double third = (corners.col(1) - corners.col(0)).cross(along).dot(normal) / area;
    const double first = 1 - second - third;
    if (first >= 0 && second >= 0 && third >= 0) offer({first, second, third});
  }
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::Index j = (i + 1) % 3;
    const Eigen::Vector3d edge = corners.col(j) - corners.col(i);
    const double squared = edge.squaredNorm();
    const double share =
        squared > 0 ? std::clamp(edge.dot(from - corners.col(i)) / squared, 0.0, 1.0) : 0;
    Eigen::Vector3d shares = Eigen::Vector3d::Zero();
    shares[i] = 1 - share;
    shares[j] = share;
    offer(shares);
  }
  return best;
}

}  // namespace ccvt
