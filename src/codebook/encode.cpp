#include "codebook/encode.h"

#include <algorithm>
#include <cmath>

#include "spatial/site_tree.h"

namespace ccvt {
namespace {

/// Up to here a k-d tree is faster than products with all sites, when these are not few.
constexpr int kTreeDimensions = 8;
constexpr std::size_t kProductSites = 128;

}  // namespace

template <class Scalar>
std::vector<Index> cheapest_sites(PointsView<Scalar> points, const WeightedSites& sites,
                                  const Arena& arena, const RankPart& part) {
  const Metric metric(points.dimension, Domain());
  if (points.dimension > kTreeDimensions || sites.count() <= kProductSites) {
    return Pricer<Scalar>(metric, points, arena, part).cheapest(sites, Ties::by_place);
  }
  // One dimension up: |p - s|^2 + (W - w) is a squared distance.
  const std::size_t dimension = sites.dimension;
  const double highest = *std::max_element(sites.weight.begin(), sites.weight.end());
  std::vector<double> lifted;
  lifted.reserve(sites.count() * (dimension + 1));
  for (const SiteNumber s : sites_below(sites.count())) {
    lifted.insert(lifted.end(), sites.at(s), sites.at(s) + dimension);
    lifted.push_back(std::sqrt(highest - sites.weight[s]));
  }
  const Metric lifted_metric(points.dimension + 1, Domain());
  const SiteTree tree(lifted_metric, lifted);
  std::vector<Index> codes(static_cast<std::size_t>(points.count));
  arena.for_ranges(codes.size(), 4096, [&](std::size_t begin, std::size_t end, int) {
    std::vector<double> query(dimension + 1, 0.0);
    for (const PointNumber p : NumberRange(PointNumber(begin), PointNumber(end))) {
      const Scalar* x = points[p.index()];
      std::copy(x, x + dimension, query.begin());
      codes[p] = tree.nearest(query.data());
    }
  });
  return codes;
}

template std::vector<Index> cheapest_sites(PointsView<float>, const WeightedSites&, const Arena&,
                                           const RankPart&);
template std::vector<Index> cheapest_sites(PointsView<double>, const WeightedSites&, const Arena&,
                                           const RankPart&);

}  // namespace ccvt
