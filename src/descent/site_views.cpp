#include "descent/site_views.h"

#include <algorithm>
#include <cmath>

#include "schedule/tiling.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 64;

}  // namespace

template <class Scalar>
void SiteViews<Scalar>::look(const Cells<Scalar>& cells, std::span<const double> position,
                             std::span<const double> radius, std::span<const double> weight,
                             std::span<const Pair> near, std::span<const double> thresholds) {
  const std::size_t sites = cells.site_count();
  link(sites, near);
  reference_.resize(sites * dimension_);
  reach_.resize(sites);
  first_at_.resize(count() * dimension_);
  now_.resize(first_at_.size());
  slope_.resize(first_at_.size());
  first_gap_.resize(count());
  room_.resize(count());
  offset_.resize(count());
  const PowerDiagram unmoved{std::vector<double>(position.size(), 0.0),
                             {weight.begin(), weight.end()}};
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    place(s, position, radius[s], weight, thresholds[s]);
    move(s, unmoved);
  });
}

/// Which sites are seen from which cells: each pair both ways.
template <class Scalar>
void SiteViews<Scalar>::link(std::size_t sites, std::span<const Pair> near) {
  Buffer<Pair> both(2 * near.size() + sites);
  arena_.for_each(near.size(), 16 * kSitesPerGrain, [&](std::size_t k) {
    both[2 * k] = near[k];
    both[2 * k + 1] = Pair(near[k].second, near[k].first);
  });
  for (const SiteNumber s : sites_below(sites)) both[2 * near.size() + s] = Pair(s, s);
  Groups<Pair> seen = pairs_by_first(arena_, std::move(both), sites);
  first_.assign(seen.first.begin(), seen.first.end());
  site_.resize(seen.items.size());
  twin_.resize(site_.size());
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    // The own site first; the others stay in order.
    const auto pairs = seen[s];
    const auto at = std::find(pairs.begin(), pairs.end(), Pair(s, s));
    std::rotate(pairs.begin(), at, at + 1);
    for (std::size_t k = 0; k < pairs.size(); ++k) site_[first_[s] + k] = pairs[k].second;
  });
  for_each_site(arena_, sites, kSitesPerGrain, [&](SiteNumber s) {
    for (const View view : of(s)) {
      for (const View other : of(site_[view])) {
        if (site_[other] == s) twin_[view] = other;
      }
    }
  });
}

template <class Scalar>
void SiteViews<Scalar>::place(SiteNumber cell, std::span<const double> position, double radius,
                              std::span<const double> weight, double threshold) {
  const double* const own_position = &position[cell * dimension_];
  double off = 0;
  for (std::size_t d = 0; d < dimension_; ++d) {
    reference_[cell * dimension_ + d] = static_cast<Scalar>(own_position[d]);
    off += std::abs(own_position[d] - double{reference_[cell * dimension_ + d]});
  }
  reach_[cell] = radius + off;
  for (const View view : of(cell)) {
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double apart =
          metric_.wrap(position[site_[view] * dimension_ + d] - own_position[d], d);
      const double from = own_position[d] - double{reference_[cell * dimension_ + d]};
      now_[view * dimension_ + d] = first_at_[view * dimension_ + d] = from + apart;
    }
  }
  for (const View view : of(cell)) {
    first_gap_[view] = gap(cell, view, weight);
    double squared = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double u = at(view)[d] - at(own(cell))[d];
      squared += u * u;
    }
    // No point of the cell is nearer to this site than to its own by more than -least.
    const double least = first_gap_[view] - 2 * std::sqrt(squared) * reach_[cell];
    room_[view] = std::max(threshold, least);
  }
}

template <class Scalar>
double SiteViews<Scalar>::squared_distance(View view) const {
  double sum = 0;
  for (std::size_t d = 0; d < dimension_; ++d) sum += at(view)[d] * at(view)[d];
  return sum;
}

template <class Scalar>
double SiteViews<Scalar>::move(SiteNumber cell, const PowerDiagram& diagram) {
  const double* const own_step = &diagram.step[cell * dimension_];
  // The own view is the first: the gaps of the others need it where it is now.
  for (const View view : of(cell)) {
    const double* const step = &diagram.step[site_[view] * dimension_];
    for (std::size_t d = 0; d < dimension_; ++d) {
      const std::size_t k = view * dimension_ + d;
      now_[k] = first_at_[k] + step[d];
      slope_[k] = static_cast<Scalar>(2 * now_[k]);
    }
  }
  double most = 0;
  for (const View view : of(cell)) {
    const double* const step = &diagram.step[site_[view] * dimension_];
    double turned = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      turned += (step[d] - own_step[d]) * (step[d] - own_step[d]);
    }
    const double change = std::abs(gap(cell, view, diagram.weight) - first_gap_[view]) +
                          2 * std::sqrt(turned) * reach_[cell];
    most = std::max(most, change / room_[view]);
    offset_[view] = static_cast<Scalar>(squared_distance(view) + diagram.weight[cell] -
                                        diagram.weight[site_[view]]);
  }
  return most;
}

template class SiteViews<float>;
template class SiteViews<double>;

}  // namespace ccvt
