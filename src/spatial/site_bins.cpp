#include "spatial/site_bins.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <utility>

#include "numbers.h"

namespace ccvt {
namespace {

/// Of the number of sites in the bin that a site is in, the greatest mean with which bins pay.
constexpr std::size_t kMostCrowded = 8;
constexpr std::size_t kPerGrain = 4096;

}  // namespace

std::optional<SiteBins> SiteBins::sort(const Metric& metric, std::span<const double> positions,
                                       const double* lower, const double* upper,
                                       const Arena& arena) {
  SiteBins bins;
  bins.dimension_ = metric.coordinate_count();
  bins.periodic_ = metric.periodic();
  const std::size_t dimension = bins.dimension_;
  if (dimension < 2 || dimension > kMostDimensions || positions.empty()) return std::nullopt;
  const std::size_t count = positions.size() / dimension;
  const auto sites = static_cast<double>(count);

  double volume = 1;
  double farthest = 0;
  for (std::size_t d = 0; d < dimension; ++d) {
    volume *= upper[d] - lower[d];
    farthest = std::max({farthest, std::abs(lower[d]), std::abs(upper[d])});
  }
  if (!(volume > 0) || !std::isfinite(volume)) return std::nullopt;
  const double width = std::pow(volume / sites, 1.0 / metric.dimension());
  double all = 1;
  for (std::size_t d = 0; d < dimension; ++d) {
    const double extent = upper[d] - lower[d];
    const double along = std::clamp(std::round(extent / width), 1.0, sites);
    bins.bins_[d] = static_cast<std::ptrdiff_t>(along);
    bins.last_[d] = along - 1;
    bins.lower_[d] = lower[d];
    bins.extent_[d] =
        metric.periodic() ? metric.extent()[d] : std::numeric_limits<double>::infinity();
    bins.width_[d] = extent / along;
    bins.inverse_width_[d] = along / extent;
    if (!std::isfinite(2 * bins.inverse_width_[d])) return std::nullopt;  // halves of bins, too
    all *= along;
  }
  constexpr double kMostBins = std::numeric_limits<std::uint32_t>::max();
  if (!(width > 0) || all > std::min(4 * sites, kMostBins)) return std::nullopt;
  bins.rounding_ = 1e-9 * width + 1e-15 * farthest;

  struct Placed {
    std::uint32_t bin;
    SiteNumber site;
  };
  const auto placed = [&](std::size_t s) {
    std::size_t bin = 0;
    for (std::size_t d = dimension; d-- > 0;) {
      bin = bin * bins.bins(d) + bins.bin_along(positions[s * dimension + d], d);
    }
    return Placed{static_cast<std::uint32_t>(bin), SiteNumber(s)};
  };
  std::size_t bin_count = 1;
  for (std::size_t d = 0; d < dimension; ++d) bin_count *= bins.bins(d);
  Groups<Placed> groups = group_by_key<Placed>(arena, count, bin_count, placed,
                                               [](const Placed& p) { return std::size_t{p.bin}; });
  const std::size_t squares = reduce(
      arena, bin_count, kPerGrain, std::size_t{0},
      [&](std::size_t begin, std::size_t end) {
        std::size_t sum = 0;
        for (std::size_t b = begin; b < end; ++b) sum += groups[b].size() * groups[b].size();
        return sum;
      },
      std::plus<>());
  if (squares > kMostCrowded * count) return std::nullopt;

  bins.sites_ = {Buffer<Index>(count), std::move(groups.first)};
  bins.position_.reset(positions.size());
  arena.for_each(count, kPerGrain, [&](std::size_t place) {
    const SiteNumber site = groups.items[place].site;
    bins.sites_.items[place] = site.index();
    std::copy_n(&positions[site * dimension], dimension, &bins.position_[place * dimension]);
  });
  return bins;
}

}  // namespace ccvt
