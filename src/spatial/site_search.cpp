#include "spatial/site_search.h"

#include <algorithm>

namespace ccvt {

SiteSearch::SiteSearch(const Metric& metric, std::span<const double> positions, const Arena& arena)
    : metric_(metric) {
  const auto dimension = metric.coordinate_count();
  std::vector<double> lower(positions.data(), positions.data() + dimension);
  std::vector<double> upper(lower);
  if (metric.periodic()) {
    lower.assign(metric.lower(), metric.lower() + dimension);
    for (std::size_t d = 0; d < dimension; ++d) upper[d] = lower[d] + metric.extent()[d];
  } else {
    for (std::size_t s = 0; s < positions.size(); s += dimension) {
      for (std::size_t d = 0; d < dimension; ++d) {
        lower[d] = std::min(lower[d], positions[s + d]);
        upper[d] = std::max(upper[d], positions[s + d]);
      }
    }
  }
  bins_ = SiteBins::sort(metric, positions, lower.data(), upper.data(), arena);
  if (bins_) return;
  positions_.assign(positions.begin(), positions.end());
  tree_.emplace(metric, positions);
}

}  // namespace ccvt
