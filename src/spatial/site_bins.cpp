#include "spatial/site_bins.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <utility>

namespace ccvt {
namespace {

/// Of the number of sites in the bin that a site is in, the greatest mean with which bins pay.
constexpr double kMostCrowded = 8;
constexpr std::size_t kPerGrain = 4096;

}  // namespace

std::optional<SiteBins> SiteBins::sort(const Metric& metric, std::span<const double> positions,
                                       const double* lower, const double* upper,
                                       const Arena& arena) {
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
  constexpr double kMostBins = std::numeric_limits<std::uint32_t>::max();
  if (!(width > 0) || all > std::min(4 * static_cast<double>(count), kMostBins))
    return std::nullopt;
  bins.rounding_ = 1e-9 * width + 1e-15 * farthest;

  struct Placed {
    std::uint32_t bin;
    Index site;
  };
  const auto placed = [&](std::size_t s) {
    std::size_t bin = 0;
    for (std::size_t d = dimension; d-- > 0;) {
      bin = bin * bins.bins_[d] + bins.bin_along(positions[s * dimension + d], d);
    }
    return Placed{static_cast<std::uint32_t>(bin), static_cast<Index>(s)};
  };
  const auto bin_count = static_cast<std::size_t>(all);
  Groups<Placed> groups = group_by_key<Placed>(arena, count, bin_count, placed,
                                               [](const Placed& p) { return std::size_t{p.bin}; });
  const double squares = sum_of(arena, bin_count, kPerGrain, [&](std::size_t b) {
    const auto held = static_cast<double>(groups[b].size());
    return held * held;
  });
  if (squares > kMostCrowded * static_cast<double>(count)) return std::nullopt;

  bins.sites_ = {Buffer<Index>(count), std::move(groups.first)};
  bins.position_.reset(positions.size());
  arena.for_each(count, kPerGrain, [&](std::size_t place) {
    const Index site = groups.items[place].site;
    bins.sites_.items[place] = site;
    std::copy_n(&positions[static_cast<std::size_t>(site) * dimension], dimension,
                &bins.position_[place * dimension]);
  });
  return bins;
}

}  // namespace ccvt
