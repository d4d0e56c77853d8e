#include "relax/deal.h"

#include <cstdint>
#include <numeric>
#include <optional>

#include "sampling/hilbert.h"
#include "spatial/site_bins.h"

namespace ccvt {
namespace {

/// Where the sites are, in bins; one bin for all where a grid does not pay.
template <class Scalar>
class Places {
 public:
  Places(const Metric& metric, const SiteState& sites, const Box& box)
      : bins_(SiteBins::sort(metric, sites.position, box.lower.data(), box.upper.data())) {
    if (!bins_) {
      all_.resize(sites.count());
      std::iota(all_.begin(), all_.end(), 0);
    }
  }

  [[nodiscard]] std::size_t bin_count() const { return bins_ ? bins_->bin_count() : 1; }
  [[nodiscard]] std::size_t bin_of(const Scalar* x) const {
    if (!bins_) return 0;
    std::size_t bin = 0;
    for (std::size_t d = bins_->dimension(); d-- > 0;) {
      bin = bin * bins_->bins(d) + bins_->bin_along(x[d], d);
    }
    return bin;
  }
  /// The bins along a curve on which near ones are near in space.
  [[nodiscard]] std::vector<std::size_t> curve() const {
    if (!bins_) return {0};
    std::vector<std::int64_t> shape;
    for (std::size_t d = 0; d < bins_->dimension(); ++d) {
      shape.push_back(static_cast<std::int64_t>(bins_->bins(d)));
    }
    std::vector<std::size_t> order;
    order.reserve(bin_count());
    HilbertCurve(shape).visit(
        [&](std::int64_t bin) { order.push_back(static_cast<std::size_t>(bin)); });
    return order;
  }
  [[nodiscard]] std::span<const Index> sites_in(std::size_t bin) const {
    return bins_ ? bins_->sites_in(bin) : std::span<const Index>(all_);
  }

 private:
  std::optional<SiteBins> bins_;
  std::vector<Index> all_;
};

}  // namespace

template <class Scalar>
std::vector<SiteNumber> deal_rest(const Metric& metric, const SiteState& sites, const Box& box,
                                  const PointsView<Scalar>& points,
                                  std::span<const Index> capacities, const Cells<Scalar>& cells,
                                  std::span<const Index> filled) {
  std::vector<SiteNumber> owners(static_cast<std::size_t>(points.count), SiteNumber::none());
  std::vector<Index> room(capacities.begin(), capacities.end());
  for (const SiteNumber site : sites_below(filled.size())) {
    for (Index k = 0; k < filled[site]; ++k) owners[cells.point(site, k)] = site;
    room[site] -= filled[site];
  }
  const Places<Scalar> places(metric, sites, box);
  // Of each bin, the place of the first site that may have room.
  std::vector<std::size_t> next(places.bin_count(), 0);
  const auto take_from = [&](std::size_t bin) {
    const auto here = places.sites_in(bin);
    for (std::size_t& k = next[bin]; k < here.size(); ++k) {
      const SiteNumber site(here[k]);
      if (room[site] == 0) continue;
      --room[site];
      return site;
    }
    return SiteNumber::none();
  };
  std::vector<std::size_t> left_in(places.bin_count() + 1, 0);
  std::vector<PointNumber> left;
  for (const PointNumber p : points_below(points.count)) {
    SiteNumber& owner = owners[p];
    if (owner != SiteNumber::none()) continue;
    const std::size_t bin = places.bin_of(points[p.index()]);
    owner = take_from(bin);
    if (owner != SiteNumber::none()) continue;
    ++left_in[bin + 1];
    left.push_back(p);
  }
  // The rest, bin by bin along the curve, to the next bins with room.
  std::partial_sum(left_in.begin(), left_in.end(), left_in.begin());
  std::vector<std::size_t> end_of(left_in.begin(), left_in.end() - 1);
  std::vector<PointNumber> by_bin(left.size());
  for (const PointNumber p : left) by_bin[end_of[places.bin_of(points[p.index()])]++] = p;
  const std::vector<std::size_t> curve = places.curve();
  auto giving = curve.begin();
  for (const std::size_t bin : curve) {
    for (std::size_t k = left_in[bin]; k < left_in[bin + 1]; ++k) {
      SiteNumber owner = take_from(*giving);
      while (owner == SiteNumber::none()) owner = take_from(*++giving);
      owners[by_bin[k]] = owner;
    }
  }
  return owners;
}

#define CCVT_INSTANTIATE(Scalar)                                                                \
  template std::vector<SiteNumber> deal_rest(const Metric&, const SiteState&, const Box&,       \
                                             const PointsView<Scalar>&, std::span<const Index>, \
                                             const Cells<Scalar>&, std::span<const Index>);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
