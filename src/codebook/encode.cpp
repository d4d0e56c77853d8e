#include "codebook/encode.h"

#include <algorithm>
#include <cmath>

#include "spatial/site_tree.h"

namespace ccvt {
namespace {

/// Up to here a k-d tree is faster than products with all sites, when these are not few.
constexpr int kTreeDimensions = 8;
constexpr Index kProductSites = 128;

}  // namespace

template <class Scalar>
std::vector<Index> cheapest_sites(PointsView<Scalar> points, const WeightedSites& sites,
                                  const Arena& arena) {
  std::vector<Index> codes(static_cast<std::size_t>(points.count), 0);
  const Metric metric(points.dimension, Domain());
  if (points.dimension > kTreeDimensions || sites.count() <= kProductSites) {
    Pricer<Scalar>(metric, points, arena).price(sites, 0, 0, codes);
    return codes;
  }
  // One dimension up: |p - s|^2 + (W - w) is a squared distance.
  const auto dimension = static_cast<std::size_t>(points.dimension);
  const double highest = *std::max_element(sites.weight.begin(), sites.weight.end());
  std::vector<double> lifted;
  lifted.reserve(static_cast<std::size_t>(sites.count()) * (dimension + 1));
  for (Index s = 0; s < sites.count(); ++s) {
    lifted.insert(lifted.end(), sites.at(s), sites.at(s) + dimension);
    lifted.push_back(std::sqrt(highest - sites.weight[static_cast<std::size_t>(s)]));
  }
  const Metric lifted_metric(points.dimension + 1, Domain());
  const SiteTree tree(lifted_metric, lifted);
  arena.for_ranges(codes.size(), 4096, [&](std::size_t begin, std::size_t end, int) {
    std::vector<double> query(dimension + 1, 0.0);
    for (std::size_t p = begin; p < end; ++p) {
      const Scalar* x = points[static_cast<Index>(p)];
      std::copy(x, x + dimension, query.begin());
      codes[p] = tree.nearest(query.data());
    }
  });
  return codes;
}

template std::vector<Index> cheapest_sites(PointsView<float>, const WeightedSites&, const Arena&);
template std::vector<Index> cheapest_sites(PointsView<double>, const WeightedSites&, const Arena&);

}  // namespace ccvt
