#include "spatial/site_bins.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace ccvt {
namespace {

/// Of the number of sites in the bin that a site is in, the greatest mean with which bins pay.
constexpr double kMostCrowded = 8;

}  // namespace

std::optional<SiteBins> SiteBins::sort(const Metric& metric, std::span<const double> positions,
                                       const double* lower, const double* upper) {
  SiteBins bins;
  bins.dimension_ = static_cast<std::size_t>(metric.dimension());
  bins.periodic_ = metric.periodic();
  const std::size_t dimension = bins.dimension_;
  if (dimension < 2 || dimension > kMostDimensions || positions.empty()) return std::nullopt;
  const std::size_t count = positions.size() / dimension;

  double volume = 1;
  double farthest = 0;
  for (std::size_t d = 0; d < dimension; ++d) {
    volume *= upper[d] - lower[d];
    farthest = std::max({farthest, std::abs(lower[d]), std::abs(upper[d])});
  }
  if (!(volume > 0) || !std::isfinite(volume)) return std::nullopt;
  const double width = std::pow(volume / static_cast<double>(count), 1.0 / metric.dimension());
  double all = 1;
  for (std::size_t d = 0; d < dimension; ++d) {
    const double extent = upper[d] - lower[d];
    const double along = std::clamp(std::round(extent / width), 1.0, static_cast<double>(count));
    bins.bins_[d] = static_cast<std::size_t>(along);
    bins.lower_[d] = lower[d];
    bins.extent_[d] =
        metric.periodic() ? metric.extent()[d] : std::numeric_limits<double>::infinity();
    bins.width_[d] = extent / along;
    bins.inverse_width_[d] = along / extent;
    if (!std::isfinite(2 * bins.inverse_width_[d])) return std::nullopt;  // halves of bins, too
    all *= along;
  }
  if (!(width > 0) || all > 4 * static_cast<double>(count)) return std::nullopt;
  bins.rounding_ = 1e-9 * width + 1e-15 * farthest;

  std::vector<std::size_t> bin(count);
  bins.first_.assign(static_cast<std::size_t>(all) + 1, 0);
  for (std::size_t s = 0; s < count; ++s) {
    for (std::size_t d = dimension; d-- > 0;) {
      bin[s] = bin[s] * bins.bins_[d] + bins.bin_along(positions[s * dimension + d], d);
    }
    ++bins.first_[bin[s] + 1];
  }
  double squares = 0;
  for (const std::size_t held : bins.first_) squares += std::pow(static_cast<double>(held), 2);
  if (squares > kMostCrowded * static_cast<double>(count)) return std::nullopt;

  std::partial_sum(bins.first_.begin(), bins.first_.end(), bins.first_.begin());
  bins.site_.resize(count);
  bins.position_.resize(positions.size());
  std::vector<std::size_t> next(bins.first_.begin(), bins.first_.end() - 1);
  for (std::size_t s = 0; s < count; ++s) {
    const std::size_t place = next[bin[s]]++;
    bins.site_[place] = static_cast<Index>(s);
    std::copy_n(&positions[s * dimension], dimension, &bins.position_[place * dimension]);
  }
  return bins;
}

}  // namespace ccvt
