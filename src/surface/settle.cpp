#include "surface/settle.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>

#include "ccvt/tessellation.h"
#include "numbers.h"

namespace ccvt {

namespace {

template <class Scalar>
Eigen::Vector3d place(PointsView<Scalar> points, Index point) {
  const Scalar* const x = points[point];
  return Eigen::Vector3d(x[0], x[1], x[2]);
}

}  // namespace

template <class Scalar>
void settle(const Triangles& triangles, const Sheets& sheets, PointsView<Scalar> points,
            std::span<const Index> on, PointsView<Scalar> centroids, const Arena& arena,
            SurfaceSamples& samples) {
  constexpr std::size_t kSitesPerGrain = 64;
  const auto count = static_cast<std::size_t>(centroids.count);
  const Tessellation cells(samples.owners, centroids.count);
  for (Columns<double>* const columns : {&samples.sites, &samples.normals, &samples.barycentric}) {
    *columns = Columns<double>(3, centroids.count);
  }
  samples.triangles.resize(count);
  samples.capacities.resize(count);
  samples.weights.resize(count);
  samples.radii.resize(count);
  std::vector<double> moved(count);
  arena.for_each(count, kSitesPerGrain, [&](std::size_t k) {
    const SiteNumber s(k);
    const Eigen::Vector3d centroid = place(centroids, s.index());
    const auto cell = cells.cell(s.index());
    double squared = 0;
    Foot best;
    Index nearest = -1;
    Index last = -1;
    for (const Index p : cell) {
      squared += (place(points, p) - centroid).squaredNorm();
      const Index triangle = on[PointNumber(p)];
      if (triangle == last) continue;
      last = triangle;
      const Foot foot = nearest_on_triangle(triangles.corners(triangle), centroid);
      if (nearest >= 0 && std::tie(foot.squared, triangle) >= std::tie(best.squared, nearest)) {
        continue;
      }
      best = foot;
      nearest = triangle;
    }
    const auto capacity = static_cast<double>(cell.size());
    const bool turned = sheets.turned[static_cast<std::size_t>(nearest)] != 0;
    const Eigen::Vector3d normal = area_vector(triangles.corners(nearest)).normalized();
    const Eigen::Index column = s.index();
    samples.sites.eigen().col(column) = triangles.in_world(nearest, best.shares);
    samples.barycentric.eigen().col(column) = best.shares;
    samples.normals.eigen().col(column) = turned ? Eigen::Vector3d(-normal) : normal;
    samples.triangles[k] = nearest;
    samples.capacities[k] = static_cast<Index>(cell.size());
    samples.weights[k] = samples.mass * (capacity / points.count);  // finite where the mass is
    samples.radii[k] = std::sqrt(2 * squared / capacity);
    moved[k] = std::sqrt(best.squared);
  });
  samples.farthest_moved = *std::max_element(moved.begin(), moved.end());
}

template void settle<float>(const Triangles&, const Sheets&, PointsView<float>,
                            std::span<const Index>, PointsView<float>, const Arena&,
                            SurfaceSamples&);
template void settle<double>(const Triangles&, const Sheets&, PointsView<double>,
                             std::span<const Index>, PointsView<double>, const Arena&,
                             SurfaceSamples&);

}  // namespace ccvt
