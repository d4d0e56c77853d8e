#include "codebook/centroids.h"

#include <algorithm>

#include "geometry/coordinate_range.h"
#include "relax/nearest_sites.h"

namespace ccvt {
namespace {

/// With more sites than this, in few dimensions, trees beat products over all sites.
constexpr std::size_t kProductSites = 256;
constexpr int kTreeDimensions = 3;

}  // namespace

std::vector<std::uint8_t> changed_cells(std::span<const Index> before, std::span<const Index> after,
                                        std::size_t cells) {
  std::vector<std::uint8_t> changed(cells, 0);
  for (std::size_t p = 0; p < before.size(); ++p) {
    if (before[p] == after[p]) continue;
    changed[SiteNumber(before[p])] = changed[SiteNumber(after[p])] = 1;
  }
  return changed;
}

template <class Scalar>
void move_to_centroids(const Metric& metric, PointsView<Scalar> points, const Grouping& groups,
                       const Arena& arena, std::vector<double>& sites,
                       std::span<const std::uint8_t> changed) {
  const std::size_t dimension = sites.size() / groups.count();
  arena.for_ranges(groups.count(), 8, [&](std::size_t begin, std::size_t end, int) {
    std::vector<double> sum(dimension);
    for (const SiteNumber s : NumberRange(SiteNumber(begin), SiteNumber(end))) {
      const auto members = groups.of(s);
      if (members.empty() || (!changed.empty() && changed[s] == 0)) continue;
      double* site = sites.data() + s * dimension;
      std::fill(sum.begin(), sum.end(), 0.0);
      if (metric.periodic()) {
        for (const PointNumber p : members) {
          const Scalar* x = points[p.index()];
          for (std::size_t d = 0; d < dimension; ++d) sum[d] += metric.wrap(x[d] - site[d], d);
        }
      } else {
        for (const PointNumber p : members) {
          const Scalar* x = points[p.index()];
          for (std::size_t d = 0; d < dimension; ++d) sum[d] += x[d] - site[d];
        }
      }
      const auto size = static_cast<double>(members.size());
      for (std::size_t d = 0; d < dimension; ++d) {
        site[d] = metric.into_box(site[d] + sum[d] / size, d);
      }
    }
  });
}

template <class Scalar>
std::vector<Index> nearest_owners(const Metric& metric, PointsView<Scalar> points,
                                  const std::vector<double>& sites, const Arena& arena) {
  const std::vector<double> weights = no_weights(sites, points.dimension);
  if (points.dimension <= kTreeDimensions && weights.size() > kProductSites) {
    SiteState state(points.dimension, static_cast<Index>(weights.size()));
    state.position = sites;
    const auto nearest =
        NearestSites<Scalar>(metric, state, box_around(points, arena), arena).owners(points, arena);
    std::vector<Index> owners(nearest.size());
    for (std::size_t p = 0; p < owners.size(); ++p) owners[p] = nearest[p].index();
    return owners;
  }
  return Pricer<Scalar>(metric, points, arena).cheapest({sites, weights});
}

template void move_to_centroids(const Metric&, PointsView<float>, const Grouping&, const Arena&,
                                std::vector<double>&, std::span<const std::uint8_t>);
template void move_to_centroids(const Metric&, PointsView<double>, const Grouping&, const Arena&,
                                std::vector<double>&, std::span<const std::uint8_t>);
template std::vector<Index> nearest_owners(const Metric&, PointsView<float>,
                                           const std::vector<double>&, const Arena&);
template std::vector<Index> nearest_owners(const Metric&, PointsView<double>,
                                           const std::vector<double>&, const Arena&);

}  // namespace ccvt
