#include "kernels/streams.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/streams.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "geometry/metric.h"

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class Scalar>
HWY_INLINE Range<Scalar> stream_range(const Scalar* stream, Index count) {
  const hn::ScalableTag<Scalar> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  if (count < lanes) {
    const auto [low, high] = std::minmax_element(stream, stream + count);
    return {*low, *high};
  }
  auto low = hn::LoadU(wide, stream + count - lanes);
  auto high = low;
  for (Index k = 0; k + lanes <= count; k += lanes) {
    const auto x = hn::LoadU(wide, stream + k);
    low = hn::Min(low, x);
    high = hn::Max(high, x);
  }
  return {hn::GetLane(hn::MinOfLanes(wide, low)), hn::GetLane(hn::MaxOfLanes(wide, high))};
}

/// Eight interleaved partial sums whatever the vector width, so that bits do not depend on it.
constexpr Index kPartials = 8;
using Partials = hn::CappedTag<double, kPartials>;

HWY_INLINE hn::Vec<Partials> load(Partials tag, const double* x) { return hn::LoadU(tag, x); }
HWY_INLINE hn::Vec<Partials> load(Partials tag, const float* x) {
  return hn::PromoteTo(tag, hn::LoadU(hn::Rebind<float, Partials>(), x));
}

/// Differences as they are.
struct Straight {
  double operator()(double difference, std::ptrdiff_t) const { return difference; }
  HWY_INLINE hn::Vec<Partials> operator()(Partials, hn::Vec<Partials> difference,
                                          std::ptrdiff_t) const {
    return difference;
  }
};

/// The shortest difference on a torus.
struct Around {
  const double* extent;
  double operator()(double difference, std::ptrdiff_t d) const {
    return shortest_difference(difference, extent[d]);
  }
  HWY_INLINE hn::Vec<Partials> operator()(Partials tag, hn::Vec<Partials> difference,
                                          std::ptrdiff_t d) const {
    const auto whole = hn::Set(tag, extent[d]);
    const auto half = hn::Set(tag, extent[d] / 2);
    const auto turn = hn::IfThenElseZero(hn::Gt(difference, half), whole);
    const auto back = hn::IfThenElseZero(hn::Lt(difference, hn::Neg(half)), whole);
    return hn::Add(hn::Sub(difference, turn), back);
  }
};

/// Calls visit(first partial, second) for the partial sums that are added up together, two vectors
/// at a time; the second is -1 when there is but one vector.
template <class Visit>
HWY_INLINE void for_partials(Visit visit) {
  const auto lanes = static_cast<Index>(hn::Lanes(Partials()));
  for (Index l = 0; l < kPartials; l += 2 * lanes) visit(l, l + lanes < kPartials ? l + lanes : -1);
}

template <class Scalar, class Shortest>
HWY_INLINE double stream_sum(const Scalar* stream, Index count, double origin, Shortest shortest) {
  const Partials tag;
  std::array<double, kPartials> sum;
  const Index whole = count - count % kPartials;
  for_partials([&](Index l, Index m) HWY_ATTR {
    const auto from = hn::Set(tag, origin);
    auto sum0 = hn::Zero(tag);
    auto sum1 = hn::Zero(tag);
    for (Index k = 0; k < whole; k += kPartials) {
      sum0 = hn::Add(sum0, shortest(tag, hn::Sub(load(tag, stream + k + l), from), 0));
      if (m < 0) continue;
      sum1 = hn::Add(sum1, shortest(tag, hn::Sub(load(tag, stream + k + m), from), 0));
    }
    hn::StoreU(sum0, tag, sum.data() + l);
    if (m >= 0) hn::StoreU(sum1, tag, sum.data() + m);
  });
  for (Index k = whole; k < count; ++k) sum.data()[k - whole] += shortest(stream[k] - origin, 0);
  return ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
}

template <class Scalar, class Dimension, class Shortest>
HWY_INLINE Spread block_spread(const Scalar* block, Index count, Dimension dimension,
                               const double* centre, Shortest shortest) {
  const Partials tag;
  std::array<double, kPartials> energy;
  std::array<double, kPartials> farthest;
  const Index whole = count - count % kPartials;
  for_partials([&](Index l, Index m) HWY_ATTR {
    const auto squared = [&](Index k) HWY_ATTR {
      auto sum = hn::Zero(tag);
      for (std::ptrdiff_t d = 0; d < dimension; ++d) {
        const auto x = load(tag, block + d * count + k);
        const auto difference = shortest(tag, hn::Sub(x, hn::Set(tag, centre[d])), d);
        sum = hn::Add(sum, hn::Mul(difference, difference));
      }
      return sum;
    };
    auto energy0 = hn::Zero(tag);
    auto energy1 = hn::Zero(tag);
    auto farthest0 = hn::Zero(tag);
    auto farthest1 = hn::Zero(tag);
    for (Index k = 0; k < whole; k += kPartials) {
      const auto squared0 = squared(k + l);
      energy0 = hn::Add(energy0, squared0);
      farthest0 = hn::Max(farthest0, squared0);
      if (m < 0) continue;
      const auto squared1 = squared(k + m);
      energy1 = hn::Add(energy1, squared1);
      farthest1 = hn::Max(farthest1, squared1);
    }
    hn::StoreU(energy0, tag, energy.data() + l);
    hn::StoreU(farthest0, tag, farthest.data() + l);
    if (m < 0) return;
    hn::StoreU(energy1, tag, energy.data() + m);
    hn::StoreU(farthest1, tag, farthest.data() + m);
  });
  for (Index k = whole; k < count; ++k) {
    double squared = 0;
    for (std::ptrdiff_t d = 0; d < dimension; ++d) {
      const double difference = shortest(block[d * count + k] - centre[d], d);
      squared += difference * difference;
    }
    double& most = farthest.data()[k - whole];
    most = std::max(most, squared);
    energy.data()[k - whole] += squared;
  }
  Spread result{0, 0};
  for (std::size_t l = 0; l < kPartials; ++l) {
    result.energy += energy[l];
    result.squared_radius = std::max(result.squared_radius, farthest[l]);
  }
  return result;
}

/// Lets the compiler unroll the loop over dimensions in the common cases.
template <class Scalar, class Shortest>
HWY_INLINE Spread any_spread(const Scalar* block, Index count, int dimension, const double* centre,
                             Shortest shortest) {
  const std::integral_constant<int, 2> two;
  const std::integral_constant<int, 3> three;
  if (dimension == 2) return block_spread(block, count, two, centre, shortest);
  if (dimension == 3) return block_spread(block, count, three, centre, shortest);
  return block_spread(block, count, dimension, centre, shortest);
}

#define CCVT_FOR_SCALAR(Scalar, Name)                                                         \
  Range<Scalar> Name##_range(const Scalar* stream, Index count) {                             \
    return stream_range(stream, count);                                                       \
  }                                                                                           \
  double Name##_sum(const Scalar* stream, Index count, double origin, double extent) {        \
    return extent > 0 ? stream_sum(stream, count, origin, Around{&extent})                    \
                      : stream_sum(stream, count, origin, Straight{});                        \
  }                                                                                           \
  Spread Name##_spread(const Scalar* block, Index count, int dimension, const double* centre, \
                       const double* extent) {                                                \
    return extent != nullptr ? any_spread(block, count, dimension, centre, Around{extent})    \
                             : any_spread(block, count, dimension, centre, Straight{});       \
  }

CCVT_FOR_SCALAR(float, float32)
CCVT_FOR_SCALAR(double, float64)
#undef CCVT_FOR_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

#define CCVT_DISPATCH(Scalar, Name)                                                           \
  HWY_EXPORT(Name##_range);                                                                   \
  HWY_EXPORT(Name##_sum);                                                                     \
  HWY_EXPORT(Name##_spread);                                                                  \
  template <>                                                                                 \
  Range<Scalar> range(const Scalar* stream, Index count) {                                    \
    return HWY_DYNAMIC_DISPATCH(Name##_range)(stream, count);                                 \
  }                                                                                           \
  template <>                                                                                 \
  double sum_from(const Scalar* stream, Index count, double origin, double extent) {          \
    return HWY_DYNAMIC_DISPATCH(Name##_sum)(stream, count, origin, extent);                   \
  }                                                                                           \
  template <>                                                                                 \
  Spread spread_around(const Scalar* block, Index count, int dimension, const double* centre, \
                       const double* extent) {                                                \
    return HWY_DYNAMIC_DISPATCH(Name##_spread)(block, count, dimension, centre, extent);      \
  }

CCVT_DISPATCH(float, float32)
CCVT_DISPATCH(double, float64)
#undef CCVT_DISPATCH

}  // namespace ccvt::kernels
#endif
