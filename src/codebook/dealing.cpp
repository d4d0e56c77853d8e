#include "codebook/dealing.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>

#include "exact/distances.h"
#include "exact/grouping.h"
#include "exact/pricing.h"
#include "geometry/chosen_points.h"
#include "numbers.h"
#include "schedule/tiling.h"
#include "spatial/site_tree.h"

namespace ccvt {
namespace {

template <class Scalar>
class Dealer {
 public:
  Dealer(PointsView<Scalar> points, std::span<const double> sites,
         std::span<const Index> capacities, const Arena& arena)
      : points_(points),
        sites_(sites),
        arena_(arena),
        metric_(points.dimension, Domain()),
        room_(capacities.begin(), capacities.end()),
        owners_(static_cast<std::size_t>(points.count)),
        left_(owners_.size()) {
    std::iota(left_.begin(), left_.end(), PointNumber(0));
  }

  std::vector<Index> deal() {
    std::size_t before = 0;
    do {
      before = left_.size();
      deal_round();
    } while (!left_.empty() && left_.size() <= before - before / kLeastShare);
    deal_rest();
    return std::move(owners_);
  }

 private:
  /// Rounds go on while each deals out one point in so many, or more.
  static constexpr std::size_t kLeastShare = 4;
  static constexpr std::size_t kSitesPerGrain = 16;

  struct Wish {
    double squared;
    PointNumber point;
    auto operator<=>(const Wish&) const = default;
  };

  [[nodiscard]] std::size_t dimension() const {
    return static_cast<std::size_t>(points_.dimension);
  }
  [[nodiscard]] const double* at(SiteNumber site) const {
    return sites_.data() + site * dimension();
  }

  void deal_round() {
    std::vector<SiteNumber> open;
    std::vector<double> position;
    for (const SiteNumber s : sites_below(room_.size())) {
      if (room_[s] == 0) continue;
      open.push_back(s);
      position.insert(position.end(), at(s), at(s) + dimension());
    }
    const bool all = left_.size() == owners_.size();
    const Points<Scalar> some = all ? Points<Scalar>() : chosen_points(points_, left_);
    const Pricer<Scalar> pricer(metric_, all ? points_ : view_points(some), arena_);
    const std::vector<double> weights(open.size(), 0.0);
    const Grouping wishes(pricer.cheapest({position, weights}), open.size());
    std::vector<std::uint8_t> given(left_.size(), 0);
    for_each_site(arena_, open.size(), kSitesPerGrain,
                  [&](SiteNumber k) { take_nearest(open[k], wishes.of(k), given); });
    std::size_t kept = 0;
    for (std::size_t k = 0; k < left_.size(); ++k) {
      if (given[k] == 0) left_[kept++] = left_[k];
    }
    left_.resize(kept);
  }

  /// `wishes`: places among those left.
  void take_nearest(SiteNumber site, std::span<const PointNumber> wishes,
                    std::vector<std::uint8_t>& given) {
    std::vector<double> squared;
    squared_distances(
        wishes, [&](PointNumber k) { return points_[left_[k].index()]; }, points_.dimension,
        at(site), squared);
    std::vector<Wish> order;
    for (std::size_t k = 0; k < wishes.size(); ++k) order.push_back({squared[k], wishes[k]});
    const std::size_t taken = std::min(order.size(), static_cast<std::size_t>(room_[site]));
    std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(taken),
                     order.end());
    for (const Wish& wish : std::span(order).first(taken)) {
      owners_[left_[wish.point]] = site.index();
      given[wish.point] = 1;
    }
    room_[site] -= static_cast<Index>(taken);
  }

  void deal_rest() {
    if (left_.empty()) return;
    SiteTree open(metric_, sites_);
    for (const SiteNumber s : sites_below(room_.size())) {
      if (room_[s] == 0) open.remove(s.index());
    }
    std::vector<double> position(dimension());
    for (const PointNumber p : left_) {
      arena_.check();
      std::copy_n(points_[p.index()], dimension(), position.begin());
      const SiteNumber site(open.nearest(position.data()));
      owners_[p] = site.index();
      if (--room_[site] == 0) open.remove(site.index());
    }
  }

  PointsView<Scalar> points_;
  std::span<const double> sites_;
  const Arena& arena_;
  Metric metric_;
  std::vector<Index> room_;
  std::vector<Index> owners_;
  std::vector<PointNumber> left_;  ///< that have no owner yet
};

}  // namespace

template <class Scalar>
std::vector<Index> deal_to_nearest(PointsView<Scalar> points, std::span<const double> sites,
                                   std::span<const Index> capacities, const Arena& arena) {
  return Dealer<Scalar>(points, sites, capacities, arena).deal();
}

template std::vector<Index> deal_to_nearest(PointsView<float>, std::span<const double>,
                                            std::span<const Index>, const Arena&);
template std::vector<Index> deal_to_nearest(PointsView<double>, std::span<const double>,
                                            std::span<const Index>, const Arena&);

}  // namespace ccvt
