#include "codebook/lloyd.h"

#include <algorithm>

#include "relax/nearest_sites.h"

namespace ccvt {
namespace {

/// With more sites than this, in few dimensions, trees beat products over all sites.
constexpr Index kProductSites = 256;
constexpr int kTreeDimensions = 3;

}  // namespace

template <class Scalar>
void move_to_centroids(const Metric& metric, PointsView<Scalar> points, const Grouping& groups,
                       const Arena& arena, std::vector<double>& sites) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  const auto count = static_cast<std::size_t>(groups.count());
  arena.for_ranges(count, 8, [&](std::size_t begin, std::size_t end, int) {
    std::vector<double> sum(dimension);
    for (std::size_t s = begin; s < end; ++s) {
      const auto members = groups.of(static_cast<Index>(s));
      if (members.empty()) continue;
      double* site = sites.data() + s * dimension;
      std::fill(sum.begin(), sum.end(), 0.0);
      if (metric.periodic()) {
        for (const Index p : members) {
          for (std::size_t d = 0; d < dimension; ++d) {
            sum[d] += metric.wrap(static_cast<double>(points[p][d]) - site[d], static_cast<int>(d));
          }
        }
      } else {
        for (const Index p : members) {
          const Scalar* x = points[p];
          for (std::size_t d = 0; d < dimension; ++d) sum[d] += static_cast<double>(x[d]) - site[d];
        }
      }
      for (std::size_t d = 0; d < dimension; ++d) {
        site[d] = metric.into_box(site[d] + sum[d] / static_cast<double>(members.size()),
                                  static_cast<int>(d));
      }
    }
  });
}

template <class Scalar>
std::vector<Index> nearest_sites(const Metric& metric, PointsView<Scalar> points,
                                 const std::vector<double>& sites, const Arena& arena) {
  const auto n = static_cast<Index>(sites.size() / static_cast<std::size_t>(points.dimension));
  std::vector<Index> owners(static_cast<std::size_t>(points.count), 0);
  if (points.dimension <= kTreeDimensions && n > kProductSites) {
    SiteState state(points.dimension, n);
    state.position = sites;
    Box box = Box::unit(points.dimension);
    for (int d = 0; d < points.dimension; ++d) box.lower[d] = static_cast<double>(points[0][d]);
    box.upper = box.lower;
    for (Index p = 1; p < points.count; ++p) {
      for (int d = 0; d < points.dimension; ++d) {
        box.lower[d] = std::min(box.lower[d], static_cast<double>(points[p][d]));
        box.upper[d] = std::max(box.upper[d], static_cast<double>(points[p][d]));
      }
    }
    const Buffer<SiteNumber> nearest =
        NearestSites<Scalar>(metric, state, box, arena).owners(points, arena);
    for (const PointNumber p : points_below(points.count)) owners[p] = nearest[p].index();
    return owners;
  }
  const std::vector<double> weights(static_cast<std::size_t>(n), 0.0);
  Pricer<Scalar>(metric, points, arena).price({points.dimension, sites, weights}, 0, 0, owners);
  return owners;
}

template void move_to_centroids(const Metric&, PointsView<float>, const Grouping&, const Arena&,
                                std::vector<double>&);
template void move_to_centroids(const Metric&, PointsView<double>, const Grouping&, const Arena&,
                                std::vector<double>&);
template std::vector<Index> nearest_sites(const Metric&, PointsView<float>,
                                          const std::vector<double>&, const Arena&);
template std::vector<Index> nearest_sites(const Metric&, PointsView<double>,
                                          const std::vector<double>&, const Arena&);

}  // namespace ccvt
