#include "kernels/power.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/power.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A vector of points. Mul and Sub are kept apart, as fused ones would change bits between
/// instruction sets.
template <class Tag, class Scalar, class Dimension>
HWY_INLINE hn::Vec<Tag> power_of(Tag tag, const Scalar* points, Index stride, Dimension dimension,
                                 const Scalar* slope, Scalar offset) {
  auto power = hn::Set(tag, offset);
  for (std::ptrdiff_t d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, points + d * stride);
    power = hn::Sub(power, hn::Mul(x, hn::Set(tag, slope[d])));
  }
  return power;
}

/// Which points of two vectors, a bit each, are contested.
template <class Tag, class Scalar, class Dimension>
HWY_INLINE std::uint64_t contested_in(Tag tag, const Scalar* points, Index stride,
                                      Dimension dimension, const PowerSites<Scalar>& sites,
                                      Scalar width) {
  const auto own = power_of(tag, points, stride, dimension, sites.slopes, sites.offsets[0]);
  auto least = hn::Set(tag, std::numeric_limits<Scalar>::infinity());
  const Scalar* slope = sites.slopes + dimension;
  for (Index c = 1; c < sites.count; ++c, slope += dimension) {
    least = hn::Min(least, power_of(tag, points, stride, dimension, slope, sites.offsets[c]));
  }
  const auto mask = hn::Lt(least, hn::Add(own, hn::Set(tag, width)));
  if (hn::AllFalse(tag, mask)) return 0;
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(tag, mask, bytes.data());
  std::uint64_t bits = 0;
  std::memcpy(&bits, bytes.data(), sizeof(bits));
  return bits;
}

template <class Scalar, class Dimension>
HWY_INLINE Index contested_of_all(const Scalar* points, Index stride, Index count,
                                  Dimension dimension, const PowerSites<Scalar>& sites,
                                  Scalar width, Index* places) {
  const hn::CappedTag<Scalar, 64> wide;  // as many as there are bits
  const hn::CappedTag<Scalar, 1> one;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  Index found = 0;
  const auto note = [&](std::uint64_t bits, Index first) {
    for (; bits != 0; bits &= bits - 1) places[found++] = first + std::countr_zero(bits);
  };
  Index k = 0;
  for (; k + lanes <= count; k += lanes) {
    note(contested_in(wide, points + k, stride, dimension, sites, width), k);
  }
  for (; k < count; ++k) note(contested_in(one, points + k, stride, dimension, sites, width), k);
  return found;
}

template <class Tag, class Scalar, class Dimension>
HWY_INLINE void nearest_of_vector(Tag tag, const Scalar* points, Index stride, Dimension dimension,
                                  const PowerSites<Scalar>& sites,
                                  const NearestPowers<Scalar>& out) {
  const hn::Rebind<Index, Tag> whole;
  auto best = hn::Set(tag, std::numeric_limits<Scalar>::infinity());
  auto second = best;
  auto nearest = hn::Zero(tag);
  auto next = nearest;
  const Scalar* slope = sites.slopes;
  for (Index c = 0; c < sites.count; ++c, slope += dimension) {
    const auto power = power_of(tag, points, stride, dimension, slope, sites.offsets[c]);
    const auto number = hn::Set(tag, static_cast<Scalar>(c));
    const auto is_best = hn::Lt(power, best);
    const auto is_second = hn::Lt(power, second);
    next = hn::IfThenElse(is_best, nearest, hn::IfThenElse(is_second, number, next));
    nearest = hn::IfThenElse(is_best, number, nearest);
    second = hn::Min(second, hn::Max(best, power));
    best = hn::Min(best, power);
  }
  hn::StoreU(hn::Sub(second, best), tag, out.margin);
  if constexpr (sizeof(Scalar) == sizeof(Index)) {
    hn::StoreU(hn::ConvertTo(whole, nearest), whole, out.nearest);
    hn::StoreU(hn::ConvertTo(whole, next), whole, out.next);
  } else {
    hn::StoreU(hn::DemoteTo(whole, nearest), whole, out.nearest);
    hn::StoreU(hn::DemoteTo(whole, next), whole, out.next);
  }
}

template <class Scalar, class Dimension>
HWY_INLINE void nearest_of_all(const Scalar* points, Index stride, Index count, Dimension dimension,
                               const PowerSites<Scalar>& sites, NearestPowers<Scalar> out) {
  const hn::ScalableTag<Scalar> tag;
  const hn::CappedTag<Scalar, 1> one;
  const auto lanes = static_cast<Index>(hn::Lanes(tag));
  const auto from = [&out](Index k) {
    return NearestPowers<Scalar>{out.nearest + k, out.next + k, out.margin + k};
  };
  Index k = 0;
  for (; k + lanes <= count; k += lanes) {
    nearest_of_vector(tag, points + k, stride, dimension, sites, from(k));
  }
  for (; k < count; ++k) nearest_of_vector(one, points + k, stride, dimension, sites, from(k));
}

/// Lets the compiler unroll the loop over dimensions in the common cases.
template <class Function>
HWY_INLINE auto with_dimension(int dimension, Function function) {
  if (dimension == 2) return function(std::integral_constant<int, 2>{});
  if (dimension == 3) return function(std::integral_constant<int, 3>{});
  return function(dimension);
}

#define CCVT_FOR_SCALAR(Scalar, Name)                                                      \
  void Name##_nearest(const Scalar* points, Index stride, Index count, int dimension,      \
                      const PowerSites<Scalar>& sites, const NearestPowers<Scalar>& out) { \
    with_dimension(dimension, [&](auto d) HWY_ATTR {                                       \
      nearest_of_all(points, stride, count, d, sites, out);                                \
    });                                                                                    \
  }                                                                                        \
  Index Name##_contested(const Scalar* points, Index stride, Index count, int dimension,   \
                         const PowerSites<Scalar>& sites, Scalar width, Index* places) {   \
    return with_dimension(dimension, [&](auto d) HWY_ATTR {                                \
      return contested_of_all(points, stride, count, d, sites, width, places);             \
    });                                                                                    \
  }
CCVT_FOR_SCALAR(float, float32)
CCVT_FOR_SCALAR(double, float64)
#undef CCVT_FOR_SCALAR

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

#define CCVT_DISPATCH(Scalar, Name)                                                               \
  HWY_EXPORT(Name##_nearest);                                                                     \
  HWY_EXPORT(Name##_contested);                                                                   \
  template <>                                                                                     \
  void nearest_powers(const Scalar* points, Index stride, Index count, int dimension,             \
                      const PowerSites<Scalar>& sites, const NearestPowers<Scalar>& out) {        \
    HWY_DYNAMIC_DISPATCH(Name##_nearest)(points, stride, count, dimension, sites, out);           \
  }                                                                                               \
  template <>                                                                                     \
  Index contested_places(const Scalar* points, Index stride, Index count, int dimension,          \
                         const PowerSites<Scalar>& sites, Scalar width, Index* places) {          \
    return HWY_DYNAMIC_DISPATCH(Name##_contested)(points, stride, count, dimension, sites, width, \
                                                  places);                                        \
  }
CCVT_DISPATCH(float, float32)
CCVT_DISPATCH(double, float64)
#undef CCVT_DISPATCH

}  // namespace ccvt::kernels
#endif
