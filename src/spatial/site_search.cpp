#include "spatial/site_search.h"

#include <vector>

#include "geometry/coordinate_range.h"
#include "numbers.h"

namespace ccvt {

SiteSearch::SiteSearch(const Metric& metric, std::span<const double> positions, const Arena& arena)
    : metric_(metric) {
  const std::size_t dimension = metric.coordinate_count();
  if (metric.periodic()) {
    std::vector<double> upper(metric.lower(), metric.lower() + dimension);
    for (std::size_t d = 0; d < dimension; ++d) upper[d] += metric.extent()[d];
    bins_ = SiteBins::sort(metric, positions, metric.lower(), upper.data(), arena);
  } else {
    const SiteNumber end(positions.size() / dimension);
    const auto range = coordinate_range(
        PointsView<double>{positions.data(), metric.dimension(), end.index(), metric.dimension()},
        arena);
    bins_ = SiteBins::sort(metric, positions, range.lower.data(), range.upper.data(), arena);
  }
  if (bins_) return;
  positions_.assign(positions.begin(), positions.end());
  tree_.emplace(metric, positions);
}

}  // namespace ccvt
