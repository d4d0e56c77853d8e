#include "relax/pair_cut.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "rounding.h"

namespace ccvt {
namespace {

/// Of the torus's extent. Not one half: rounding must not decide which image is the nearest.
constexpr double kLargestFrame = 0.499;

}  // namespace

template <class Scalar>
PairCut<Scalar>::PairCut(const Metric& metric, double coordinate_bound)
    : metric_(metric),
      place_(metric.periodic() ? place_for<true>(metric.dimension())
                               : place_for<false>(metric.dimension())),
      least_extent_(std::numeric_limits<double>::infinity()),
      placement_(metric.largest_extent() + coordinate_bound) {
  const auto size = static_cast<std::size_t>(metric.dimension());
  const double terms = metric.dimension() + 4;
  rounding_of_size_ = 4 * terms * kHalfUlp;
  tolerance_of_size_ = 2 * terms * std::numeric_limits<Scalar>::epsilon();
  least_rounding_ = 16 * terms * std::numeric_limits<double>::denorm_min();
  least_tolerance_ = terms * std::numeric_limits<Scalar>::min();
  for (auto* vector : {&normal_, &middle_i_, &middle_j_}) vector->resize(size);
  for (auto* vector : {&scalar_normal_, &scalar_middle_i_, &scalar_middle_j_}) vector->resize(size);
  if (!metric.periodic()) return;
  least_extent_ = *std::min_element(metric.extent(), metric.extent() + size);
  largest_wrapped_ = kLargestFrame - 2 * std::numeric_limits<Scalar>::epsilon() *
                                         (1 + coordinate_bound / least_extent_);
  extent_.assign(metric.extent(), metric.extent() + size);
  for (std::size_t d = 0; d < size; ++d) {
    inverse_extent_.push_back(static_cast<Scalar>(1 / metric.extent()[d]));
  }
  turn_.resize(size);
}

template <class Scalar>
template <bool Periodic>
auto PairCut<Scalar>::place_for(int dimension) -> Place {
  if (dimension == 2) return &PairCut::place_in<2, Periodic>;
  if (dimension == 3) return &PairCut::place_in<3, Periodic>;
  return &PairCut::place_in<0, Periodic>;
}

/// A straight cut needs both cells in one frame: no point of either cell may be nearer to another
/// image of a site. `Dimension`: 0 for any. Where it is known, loops are unrolled.
template <class Scalar>
template <std::size_t Dimension, bool Periodic>
void PairCut<Scalar>::place_in(const SiteState& sites, SiteNumber i, SiteNumber j) {
  const std::size_t dimension = Dimension > 0 ? Dimension : normal_.size();
  site_i_ = sites.at(i);
  site_j_ = sites.at(j);
  double squared_length = 0;
  bool shifted = false;
  for (std::size_t d = 0; d < dimension; ++d) {
    const double at_i = site_i_[d];
    const double raw = site_j_[d] - at_i;
    const double u = Periodic ? shortest_difference(raw, metric_.extent()[d]) : raw;
    const double middle = at_i + u / 2;
    shifted = shifted | (u != raw);
    squared_length += u * u;
    normal_[d] = u;
    middle_i_[d] = middle_j_[d] = middle;
    scalar_normal_[d] = static_cast<Scalar>(u);
    scalar_middle_i_[d] = scalar_middle_j_[d] = static_cast<Scalar>(middle);
  }
  length_ = std::sqrt(squared_length);
  const double radius = std::max(sites.radius[i], sites.radius[j]);
  frame_ = Frame::plain;
  crosses_faces_ = shifted;
  if constexpr (Periodic) {
    const bool compact = (sites.compact[i] & sites.compact[j]) != 0;
    const bool small = length_ + radius <= largest_wrapped_ * least_extent_;
    if (!compact || shifted || !small) frame_ = frame_across(radius, compact, small);
  }
  bound_errors(radius);
}

/// The frame of a pair on a torus, and where the cut is in it.
template <class Scalar>
auto PairCut<Scalar>::frame_across(double radius, bool compact, bool small) -> Frame {
  const std::size_t dimension = normal_.size();
  const double largest = compact ? kLargestFrame : largest_wrapped_;
  bool too_large = false;
  for (std::size_t d = 0; !small && d < dimension; ++d) {
    too_large = too_large || std::abs(normal_[d]) + radius > largest * metric_.extent()[d];
  }
  if (too_large) {
    crosses_faces_ = true;
    std::copy_n(site_i_, dimension, scalar_middle_i_.begin());
    std::copy_n(site_j_, dimension, scalar_middle_j_.begin());
    return Frame::none;
  }
  if (compact) {
    for (std::size_t d = 0; d < dimension; ++d) {
      if (normal_[d] == site_j_[d] - site_i_[d]) continue;
      middle_j_[d] = site_j_[d] - normal_[d] / 2;
      scalar_middle_j_[d] = static_cast<Scalar>(middle_j_[d]);
    }
    return Frame::plain;
  }
  int crossed = 0;
  for (std::size_t d = 0; d < dimension; ++d) {
    const auto k = static_cast<int>(d);
    const bool crosses = normal_[d] != site_j_[d] - site_i_[d] ||
                         metric_.reaches_face(site_i_[d], radius, k) ||
                         metric_.reaches_face(site_j_[d], radius, k);
    crossed += crosses ? 1 : 0;
    across_ = crosses ? d : across_;
  }
  if (crossed == 0) return Frame::plain;
  crosses_faces_ = true;
  const auto unroll = [&](std::size_t d) {
    const Metric::Unrolled frame = metric_.unrolled(middle_i_[d], static_cast<int>(d));
    scalar_middle_i_[d] = static_cast<Scalar>(frame.origin);
    turn_[d] = static_cast<Scalar>(frame.turn);
  };
  if (crossed == 1) {
    unroll(across_);
    return Frame::one_face;
  }
  for (std::size_t d = 0; d < dimension; ++d) unroll(d);
  return Frame::wrapped;
}

/// Across faces a difference to the cut is rounded as coordinates are, and the normal as extents
/// are; else both cells see the same cut, and the rounding of its place does not matter.
template <class Scalar>
void PairCut<Scalar>::bound_errors(double radius) {
  const double reach = length_ + radius;
  double size = length_ * reach;
  if (frame_ == Frame::none) {
    size = reach * (reach + placement_);
  } else if (crosses_faces_) {
    size += length_ * placement_ + reach * metric_.largest_extent();
  }
  rounding_ = rounding_of_size_ * size + least_rounding_;
  tolerance_ = tolerance_of_size_ * size + least_tolerance_;
}

template <class Scalar>
double PairCut<Scalar>::key(Side side, const Scalar* block, Index count, Index place) const {
  const std::vector<double>& origin = middle(side);
  double key = 0;
  const Scalar* x = block + place;
  for (std::size_t d = 0; d < normal_.size(); ++d, x += count) {
    const auto k = static_cast<int>(d);
    if (frame_ == Frame::plain) {
      key += (*x - origin[d]) * normal_[d];
    } else if (frame_ == Frame::none) {
      const double to_i = metric_.wrap(*x - site_i_[d], k);
      const double to_j = metric_.wrap(*x - site_j_[d], k);
      key += (to_i * to_i - to_j * to_j) / 2;
    } else {
      key += metric_.wrap(*x - middle_i_[d], k) * normal_[d];
    }
  }
  return key;
}

template <class Scalar>
void PairCut<Scalar>::add_keys(Side side, const Scalar* block, Index count, double* keys) const {
  for (std::size_t d = 0; d < normal_.size(); ++d, block += count) {
    const double along = normal_[d];
    const auto add = [&](auto term) {
      for (Index k = 0; k < count; ++k) keys[k] += term(block[k]);
    };
    if (frame_ == Frame::plain) {
      add([along, origin = middle(side)[d]](double x) { return (x - origin) * along; });
      continue;
    }
    const auto shortest = [extent = metric_.extent()[d]](double difference) {
      return shortest_difference(difference, extent);
    };
    if (frame_ == Frame::none) {
      add([=, at_i = site_i_[d], at_j = site_j_[d]](double x) {
        const double to_i = shortest(x - at_i);
        const double to_j = shortest(x - at_j);
        return (to_i * to_i - to_j * to_j) / 2;
      });
    } else {
      add([=, origin = middle_i_[d]](double x) { return shortest(x - origin) * along; });
    }
  }
}

/// The cut is where the kernels have it, rounded. Coordinates of a box need not be those of any one
/// point, and of a point that has left the cell some may be: the sizes of the terms are bounded
/// anew.
template <class Scalar>
void PairCut<Scalar>::bound_keys(Side side, std::span<const Scalar> low,
                                 std::span<const Scalar> high, std::vector<double>& bounds) const {
  const std::size_t boxes = low.size() / normal_.size() - 1;
  const std::vector<Scalar>& origin = side == Side::i ? scalar_middle_i_ : scalar_middle_j_;
  bounds.assign(boxes, 0.0);
  double size = 0;
  for (std::size_t d = 0; d < normal_.size(); ++d) {
    const double along = scalar_normal_[d];
    const double from = origin[d];
    const Scalar* const end =
        ((along > 0) == (side == Side::i) ? high : low).data() + d * (boxes + 1);
    for (std::size_t k = 0; k < boxes; ++k) bounds[k] += (end[k] - from) * along;
    const std::size_t all = d * (boxes + 1) + boxes;
    size += std::max(std::abs(low[all] - from), std::abs(high[all] - from)) * std::abs(along);
  }
  const double slack = tolerance_ + rounding_of_size_ * size + least_rounding_;
  for (double& bound : bounds) bound += side == Side::i ? slack : -slack;
}

template <class Scalar>
double PairCut<Scalar>::kernels_differ(Side side) const {
  const std::vector<Scalar>& origin = side == Side::i ? scalar_middle_i_ : scalar_middle_j_;
  double by = 0;
  for (std::size_t d = 0; d < normal_.size(); ++d) {
    by += (middle(side)[d] - origin[d]) * normal_[d];
  }
  return by;
}

template <class Scalar>
void PairCut<Scalar>::keep(Side side, std::span<const Scalar> low, std::span<const Scalar> high,
                           Kept& kept) const {
  const std::vector<Scalar>& origin = side == Side::i ? scalar_middle_i_ : scalar_middle_j_;
  const std::size_t dimension = normal_.size();
  const std::size_t boxes = low.size() / dimension;
  kept.numbers.resize(4 * dimension);
  for (std::size_t d = 0; d < dimension; ++d) {
    const std::size_t last = d * boxes + boxes - 1;
    const Scalar of_axis[] = {origin[d], scalar_normal_[d], low[last], high[last]};
    for (std::size_t k = 0; k < 4; ++k) kept.numbers[k * dimension + d] = of_axis[k];
  }
  kept.tolerance = tolerance_;
}

/// The keys by two cuts differ by what is linear in the coordinates: it is largest in a corner.
template <class Scalar>
auto PairCut<Scalar>::bounds_since(Side side, const Kept& kept, double limit) const -> Bounds {
  const std::vector<Scalar>& origin = side == Side::i ? scalar_middle_i_ : scalar_middle_j_;
  const double sign = side == Side::i ? 1 : -1;
  double of_kernels = 0;
  double exact = 0;
  double size = 0;
  for (std::size_t d = 0; d < normal_.size(); ++d) {
    const double low = kept.low()[d];
    const double high = kept.high()[d];
    const double at_low = (low - kept.cut().middle[d]) * kept.cut().normal[d];
    const double at_high = (high - kept.cut().middle[d]) * kept.cut().normal[d];
    const auto add = [&](double from, double along, double& bound) {
      const double low_now = (low - from) * along;
      const double high_now = (high - from) * along;
      bound += std::max(sign * (low_now - at_low), sign * (high_now - at_high));
      size += std::max(std::abs(low_now), std::abs(high_now));
    };
    add(origin[d], scalar_normal_[d], of_kernels);
    add(middle(side)[d], normal_[d], exact);
    size += 2 * std::max(std::abs(at_low), std::abs(at_high));
  }
  const double slack = kept.tolerance + rounding_of_size_ * size + least_rounding_;
  return {limit + sign * (of_kernels + slack + tolerance_),
          limit + sign * (exact + slack + rounding_)};
}

template class PairCut<float>;
template class PairCut<double>;

}  // namespace ccvt
