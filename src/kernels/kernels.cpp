#include "kernels/kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/kernels.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <limits>

#include "geometry/metric.h"

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// How a term is added to a key. Fused, the last bits of keys depend on the instruction set: only
/// for what is compared with room for rounding.
struct Fused {
  template <class V>
  HWY_INLINE V operator()(V key, V difference, V normal) const {
    return hn::MulAdd(difference, normal, key);
  }
};
struct Apart {
  template <class V>
  HWY_INLINE V operator()(V key, V difference, V normal) const {
    return hn::Add(key, hn::Mul(difference, normal));
  }
};

/// Evaluates a Cut for the points k, k + 1, … of a vector.
template <class Tag, class Scalar, class Add>
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index count, int dimension,
                               const Cut<Scalar>& cut, Index k, Add add) {
  auto key = hn::Zero(tag);
  for (int d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, block + static_cast<std::ptrdiff_t>(d) * count + k);
    key = add(key, hn::Sub(x, hn::Set(tag, cut.middle[d])), hn::Set(tag, cut.normal[d]));
  }
  return key;
}

template <class Tag, class Scalar, class Add>
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index count, int dimension,
                               const WrappedCut<Scalar>& cut, Index k, Add add) {
  auto key = hn::Zero(tag);
  for (int d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, block + static_cast<std::ptrdiff_t>(d) * count + k);
    const auto around =
        hn::IfThenElseZero(hn::Lt(x, hn::Set(tag, cut.turn[d])), hn::Set(tag, cut.extent[d]));
    const auto difference = hn::Add(hn::Sub(x, hn::Set(tag, cut.origin[d])), around);
    key = add(key, difference, hn::Set(tag, cut.normal[d]));
  }
  return key;
}

template <class Tag, class Scalar, class Add>
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index count, int dimension,
                               const FaceCut<Scalar>& cut, Index k, Add add) {
  const Cut<Scalar> straight{cut.origin, cut.normal};
  const auto key = key_at(tag, block, count, dimension, straight, k, add);
  const auto x = hn::LoadU(tag, block + static_cast<std::ptrdiff_t>(cut.across) * count + k);
  const auto jump = hn::IfThenElseZero(hn::Lt(x, hn::Set(tag, cut.turn)), hn::Set(tag, cut.jump));
  return hn::Add(key, jump);
}

/// Turns are whole numbers, -1, 0 or 1: fused or not, the bits are the same.
template <class Tag, class Scalar>
HWY_INLINE hn::Vec<Tag> wrapped(Tag tag, hn::Vec<Tag> difference, Scalar extent, Scalar inverse) {
  const auto turns = hn::Round(hn::Mul(difference, hn::Set(tag, inverse)));
  return hn::NegMulAdd(turns, hn::Set(tag, extent), difference);
}

template <class Tag, class Scalar, class Add>
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index count, int dimension,
                               const TorusCut<Scalar>& cut, Index k, Add /*add*/) {
  auto key = hn::Zero(tag);
  for (int d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, block + static_cast<std::ptrdiff_t>(d) * count + k);
    const auto to = [&](const Scalar* site) HWY_ATTR {
      return wrapped(tag, hn::Sub(x, hn::Set(tag, site[d])), cut.extent[d], cut.inverse_extent[d]);
    };
    const auto to_a = to(cut.a);
    const auto to_b = to(cut.b);
    key = hn::Add(key, hn::Sub(hn::Mul(to_a, to_a), hn::Mul(to_b, to_b)));
  }
  return hn::Mul(key, hn::Set(tag, Scalar{0.5}));
}

/// The highest key of a block, or the lowest. The last full vector may overlap the one before it:
/// extremes do not mind.
template <bool Highest, class Scalar, class AnyCut>
HWY_INLINE Scalar extreme_of(const Scalar* block, Index count, int dimension, const AnyCut& cut) {
  const hn::ScalableTag<Scalar> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  const auto beyond = [](auto a, auto b)
                          HWY_ATTR { return Highest ? hn::Max(a, b) : hn::Min(a, b); };
  if (count < lanes) {
    const hn::CappedTag<Scalar, 1> one;
    auto extreme = key_at(one, block, count, dimension, cut, 0, Fused());
    for (Index k = 1; k < count; ++k) {
      extreme = beyond(extreme, key_at(one, block, count, dimension, cut, k, Fused()));
    }
    return hn::GetLane(extreme);
  }
  auto extreme0 = key_at(wide, block, count, dimension, cut, count - lanes, Fused());
  auto extreme1 = extreme0;
  Index k = 0;
  for (; k + 2 * lanes <= count; k += 2 * lanes) {
    extreme0 = beyond(extreme0, key_at(wide, block, count, dimension, cut, k, Fused()));
    extreme1 = beyond(extreme1, key_at(wide, block, count, dimension, cut, k + lanes, Fused()));
  }
  if (k + lanes <= count) {
    extreme0 = beyond(extreme0, key_at(wide, block, count, dimension, cut, k, Fused()));
  }
  const auto extreme = beyond(extreme0, extreme1);
  return hn::GetLane(Highest ? hn::MaxOfLanes(wide, extreme) : hn::MinOfLanes(wide, extreme));
}

template <class Scalar, class AnyCut>
HWY_INLINE void keys_of(const Scalar* block, Index count, int dimension, const AnyCut& cut,
                        Scalar* out) {
  const hn::ScalableTag<Scalar> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  Index k = 0;
  for (; k + lanes <= count; k += lanes) {
    hn::StoreU(key_at(wide, block, count, dimension, cut, k, Apart()), wide, out + k);
  }
  const hn::CappedTag<Scalar, 1> one;
  for (; k < count; ++k)
    out[k] = hn::GetLane(key_at(one, block, count, dimension, cut, k, Apart()));
}

/// Lets the compiler unroll the loop over dimensions in the common cases.
template <class Function>
HWY_INLINE auto with_dimension(int dimension, Function function) {
  if (dimension == 2) return function(std::integral_constant<int, 2>{});
  if (dimension == 3) return function(std::integral_constant<int, 3>{});
  return function(dimension);
}

template <class Scalar, class AnyCut>
HWY_INLINE Extremes<Scalar> any_extremes(const Scalar* block_i, Index count_i, const AnyCut& cut_i,
                                         const Scalar* block_j, Index count_j, const AnyCut& cut_j,
                                         int dimension) {
  return with_dimension(dimension, [&](auto d) HWY_ATTR {
    return Extremes<Scalar>{extreme_of<true>(block_i, count_i, d, cut_i),
                            extreme_of<false>(block_j, count_j, d, cut_j)};
  });
}

template <class Scalar, class AnyCut>
HWY_INLINE void any_keys(const Scalar* block, Index count, int dimension, const AnyCut& cut,
                         Scalar* out) {
  with_dimension(dimension, [&](auto d) HWY_ATTR { keys_of(block, count, d, cut, out); });
}

/// The last full vector overlaps the one before it, as in extreme_of(); its bits are then those of
/// the points that remain.
template <bool Above, class Scalar, class Dimension, class AnyCut>
HWY_INLINE Index places_in(const Scalar* block, Index count, Dimension dimension, const AnyCut& cut,
                           Scalar threshold, Index* places) {
  const auto found_at = [&](auto tag, Index k) HWY_ATTR {
    const auto key = key_at(tag, block, count, dimension, cut, k, Fused());
    const auto limit = hn::Set(tag, threshold);
    const auto mask = Above ? hn::Gt(key, limit) : hn::Lt(key, limit);
    std::uint64_t bits = 0;
    if (hn::AllFalse(tag, mask)) return bits;
    std::array<std::uint8_t, 8> bytes{};
    hn::StoreMaskBits(tag, mask, bytes.data());
    std::memcpy(&bits, bytes.data(), sizeof(bits));
    return bits;
  };
  Index found = 0;
  const auto note = [&](std::uint64_t bits, Index first) {
    for (; bits != 0; bits &= bits - 1) places[found++] = first + std::countr_zero(bits);
  };
  const hn::ScalableTag<Scalar> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  if (count < lanes) {
    const hn::CappedTag<Scalar, 1> one;
    for (Index k = 0; k < count; ++k) note(found_at(one, k), k);
    return found;
  }
  Index k = 0;
  for (; k + lanes <= count; k += lanes) note(found_at(wide, k), k);
  if (k < count) note(found_at(wide, count - lanes) >> (k + lanes - count), k);
  return found;
}

template <class Scalar, class AnyCut>
HWY_INLINE Index any_places(const Scalar* block, Index count, int dimension, const AnyCut& cut,
                            Beyond beyond, Scalar threshold, Index* places) {
  return with_dimension(dimension, [&](auto d) HWY_ATTR {
    return beyond == Beyond::above ? places_in<true>(block, count, d, cut, threshold, places)
                                   : places_in<false>(block, count, d, cut, threshold, places);
  });
}

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
  double operator()(double difference, int) const { return difference; }
  HWY_INLINE hn::Vec<Partials> operator()(Partials, hn::Vec<Partials> difference, int) const {
    return difference;
  }
};

/// The shortest difference on a torus.
struct Around {
  const double* extent;
  double operator()(double difference, int d) const {
    return shortest_difference(difference, extent[d]);
  }
  HWY_INLINE hn::Vec<Partials> operator()(Partials tag, hn::Vec<Partials> difference, int d) const {
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
  for (Index k = whole; k < count; ++k) {
    sum[static_cast<std::size_t>(k - whole)] +=
        shortest(static_cast<double>(stream[k]) - origin, 0);
  }
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
      for (int d = 0; d < dimension; ++d) {
        const auto x = load(tag, block + static_cast<std::ptrdiff_t>(d) * count + k);
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
    for (int d = 0; d < dimension; ++d) {
      const auto x = static_cast<double>(block[static_cast<std::ptrdiff_t>(d) * count + k]);
      const double difference = shortest(x - centre[d], d);
      squared += difference * difference;
    }
    const auto l = static_cast<std::size_t>(k - whole);
    energy[l] += squared;
    farthest[l] = std::max(farthest[l], squared);
  }
  Spread result{0, 0};
  for (std::size_t l = 0; l < kPartials; ++l) {
    result.energy += energy[l];
    result.squared_radius = std::max(result.squared_radius, farthest[l]);
  }
  return result;
}

#define CCVT_FOR_CUT(Scalar, Name, AnyCut)                                                    \
  Extremes<Scalar> Name##_extremes(const Scalar* block_i, Index count_i, const AnyCut& cut_i, \
                                   const Scalar* block_j, Index count_j, const AnyCut& cut_j, \
                                   int dimension) {                                           \
    return any_extremes(block_i, count_i, cut_i, block_j, count_j, cut_j, dimension);         \
  }                                                                                           \
  void Name##_keys(const Scalar* block, Index count, int dimension, const AnyCut& cut,        \
                   Scalar* out) {                                                             \
    any_keys(block, count, dimension, cut, out);                                              \
  }                                                                                           \
  Index Name##_places(const Scalar* block, Index count, int dimension, const AnyCut& cut,     \
                      Beyond beyond, Scalar threshold, Index* places) {                       \
    return any_places(block, count, dimension, cut, beyond, threshold, places);               \
  }
#define CCVT_FOR_SCALAR(Scalar, Name)                                                         \
  CCVT_FOR_CUT(Scalar, Name, Cut<Scalar>)                                                     \
  CCVT_FOR_CUT(Scalar, Name##_wrapped, WrappedCut<Scalar>)                                    \
  CCVT_FOR_CUT(Scalar, Name##_face, FaceCut<Scalar>)                                          \
  CCVT_FOR_CUT(Scalar, Name##_torus, TorusCut<Scalar>)                                        \
  Range<Scalar> Name##_range(const Scalar* stream, Index count) {                             \
    return stream_range(stream, count);                                                       \
  }                                                                                           \
  double Name##_sum(const Scalar* stream, Index count, double origin, double extent) {        \
    return extent > 0 ? stream_sum(stream, count, origin, Around{&extent})                    \
                      : stream_sum(stream, count, origin, Straight{});                        \
  }                                                                                           \
  Spread Name##_spread(const Scalar* block, Index count, int dimension, const double* centre, \
                       const double* extent) {                                                \
    return with_dimension(dimension, [=](auto d) HWY_ATTR {                                   \
      return extent != nullptr ? block_spread(block, count, d, centre, Around{extent})        \
                               : block_spread(block, count, d, centre, Straight{});           \
    });                                                                                       \
  }

CCVT_FOR_SCALAR(float, float32)
CCVT_FOR_SCALAR(double, float64)
#undef CCVT_FOR_SCALAR
#undef CCVT_FOR_CUT

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

#define CCVT_DISPATCH_CUT(Scalar, Name, AnyCut)                                                    \
  HWY_EXPORT(Name##_extremes);                                                                     \
  HWY_EXPORT(Name##_keys);                                                                         \
  HWY_EXPORT(Name##_places);                                                                       \
  template <>                                                                                      \
  Extremes<Scalar> key_extremes(const Scalar* block_i, Index count_i, const AnyCut& cut_i,         \
                                const Scalar* block_j, Index count_j, const AnyCut& cut_j,         \
                                int dimension) {                                                   \
    return HWY_DYNAMIC_DISPATCH(Name##_extremes)(block_i, count_i, cut_i, block_j, count_j, cut_j, \
                                                 dimension);                                       \
  }                                                                                                \
  template <>                                                                                      \
  void keys(const Scalar* block, Index count, int dimension, const AnyCut& cut, Scalar* out) {     \
    HWY_DYNAMIC_DISPATCH(Name##_keys)(block, count, dimension, cut, out);                          \
  }                                                                                                \
  template <>                                                                                      \
  Index places_beyond(const Scalar* block, Index count, int dimension, const AnyCut& cut,          \
                      Beyond beyond, Scalar threshold, Index* places) {                            \
    return HWY_DYNAMIC_DISPATCH(Name##_places)(block, count, dimension, cut, beyond, threshold,    \
                                               places);                                            \
  }
#define CCVT_DISPATCH(Scalar, Name)                                                           \
  CCVT_DISPATCH_CUT(Scalar, Name, Cut<Scalar>)                                                \
  CCVT_DISPATCH_CUT(Scalar, Name##_wrapped, WrappedCut<Scalar>)                               \
  CCVT_DISPATCH_CUT(Scalar, Name##_face, FaceCut<Scalar>)                                     \
  CCVT_DISPATCH_CUT(Scalar, Name##_torus, TorusCut<Scalar>)                                   \
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
#undef CCVT_DISPATCH_CUT

}  // namespace ccvt::kernels
#endif
