#include "kernels/keys.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/keys.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <type_traits>

/// Every kind of cut, with the name that its functions begin with.
#define CCVT_FOR_CUTS(Each, Scalar, Name)                                          \
  Each(Scalar, Name, Cut<Scalar>) Each(Scalar, Name##_wrapped, WrappedCut<Scalar>) \
      Each(Scalar, Name##_face, FaceCut<Scalar>) Each(Scalar, Name##_torus, TorusCut<Scalar>)

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
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index stride, int dimension,
                               const Cut<Scalar>& cut, Index k, Add add) {
  auto key = hn::Zero(tag);
  for (std::ptrdiff_t d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, block + d * stride + k);
    key = add(key, hn::Sub(x, hn::Set(tag, cut.middle[d])), hn::Set(tag, cut.normal[d]));
  }
  return key;
}

template <class Tag, class Scalar, class Add>
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index stride, int dimension,
                               const WrappedCut<Scalar>& cut, Index k, Add add) {
  auto key = hn::Zero(tag);
  for (std::ptrdiff_t d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, block + d * stride + k);
    const auto around =
        hn::IfThenElseZero(hn::Lt(x, hn::Set(tag, cut.turn[d])), hn::Set(tag, cut.extent[d]));
    const auto difference = hn::Add(hn::Sub(x, hn::Set(tag, cut.origin[d])), around);
    key = add(key, difference, hn::Set(tag, cut.normal[d]));
  }
  return key;
}

template <class Tag, class Scalar, class Add>
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index stride, int dimension,
                               const FaceCut<Scalar>& cut, Index k, Add add) {
  const Cut<Scalar> straight{cut.origin, cut.normal};
  const auto key = key_at(tag, block, stride, dimension, straight, k, add);
  const std::ptrdiff_t across = cut.across;
  const auto x = hn::LoadU(tag, block + across * stride + k);
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
HWY_INLINE hn::Vec<Tag> key_at(Tag tag, const Scalar* block, Index stride, int dimension,
                               const TorusCut<Scalar>& cut, Index k, Add /*add*/) {
  auto key = hn::Zero(tag);
  for (std::ptrdiff_t d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, block + d * stride + k);
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
/// extremes do not mind. Compiled once for whoever calls it: that is a third of this file.
template <bool Highest, class Scalar, class Dimension, class AnyCut>
HWY_NOINLINE Scalar extreme_of(const Scalar* block, Index stride, Index count, Dimension dimension,
                               const AnyCut& cut) {
  const hn::ScalableTag<Scalar> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  const auto beyond = [](auto a, auto b)
                          HWY_ATTR { return Highest ? hn::Max(a, b) : hn::Min(a, b); };
  if (count < lanes) {
    const hn::CappedTag<Scalar, 1> one;
    auto extreme = key_at(one, block, stride, dimension, cut, 0, Fused());
    for (Index k = 1; k < count; ++k) {
      extreme = beyond(extreme, key_at(one, block, stride, dimension, cut, k, Fused()));
    }
    return hn::GetLane(extreme);
  }
  auto extreme0 = key_at(wide, block, stride, dimension, cut, count - lanes, Fused());
  auto extreme1 = extreme0;
  Index k = 0;
  for (; k + 2 * lanes <= count; k += 2 * lanes) {
    extreme0 = beyond(extreme0, key_at(wide, block, stride, dimension, cut, k, Fused()));
    extreme1 = beyond(extreme1, key_at(wide, block, stride, dimension, cut, k + lanes, Fused()));
  }
  if (k + lanes <= count) {
    extreme0 = beyond(extreme0, key_at(wide, block, stride, dimension, cut, k, Fused()));
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
    return Extremes<Scalar>{extreme_of<true>(block_i, count_i, count_i, d, cut_i),
                            extreme_of<false>(block_j, count_j, count_j, d, cut_j)};
  });
}

template <class Scalar, class AnyCut>
HWY_INLINE Scalar any_extreme(const Scalar* block, Index stride, Index count, int dimension,
                              const AnyCut& cut, Beyond beyond) {
  return with_dimension(dimension, [&](auto d) HWY_ATTR {
    return beyond == Beyond::above ? extreme_of<true>(block, stride, count, d, cut)
                                   : extreme_of<false>(block, stride, count, d, cut);
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
HWY_INLINE Index places_in(const Scalar* block, Index stride, Index count, Dimension dimension,
                           const AnyCut& cut, Scalar threshold, Index* places) {
  const auto found_at = [&](auto tag, Index k) HWY_ATTR {
    const auto key = key_at(tag, block, stride, dimension, cut, k, Fused());
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
  const hn::CappedTag<Scalar, 64> wide;  // as many as there are bits
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
HWY_INLINE Index any_places(const Scalar* block, Index stride, Index count, int dimension,
                            const AnyCut& cut, Beyond beyond, Scalar threshold, Index* places) {
  return with_dimension(dimension, [&](auto d) HWY_ATTR {
    return beyond == Beyond::above
               ? places_in<true>(block, stride, count, d, cut, threshold, places)
               : places_in<false>(block, stride, count, d, cut, threshold, places);
  });
}

#define CCVT_FOR_CUT(Scalar, Name, AnyCut)                                                    \
  Extremes<Scalar> Name##_extremes(const Scalar* block_i, Index count_i, const AnyCut& cut_i, \
                                   const Scalar* block_j, Index count_j, const AnyCut& cut_j, \
                                   int dimension) {                                           \
    return any_extremes(block_i, count_i, cut_i, block_j, count_j, cut_j, dimension);         \
  }                                                                                           \
  Scalar Name##_extreme(const Scalar* block, Index stride, Index count, int dimension,        \
                        const AnyCut& cut, Beyond beyond) {                                   \
    return any_extreme(block, stride, count, dimension, cut, beyond);                         \
  }                                                                                           \
  void Name##_keys(const Scalar* block, Index count, int dimension, const AnyCut& cut,        \
                   Scalar* out) {                                                             \
    any_keys(block, count, dimension, cut, out);                                              \
  }                                                                                           \
  Index Name##_places(const Scalar* block, Index stride, Index count, int dimension,          \
                      const AnyCut& cut, Beyond beyond, Scalar threshold, Index* places) {    \
    return any_places(block, stride, count, dimension, cut, beyond, threshold, places);       \
  }
CCVT_FOR_CUTS(CCVT_FOR_CUT, float, float32)
CCVT_FOR_CUTS(CCVT_FOR_CUT, double, float64)
#undef CCVT_FOR_CUT

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

#define CCVT_DISPATCH_CUT(Scalar, Name, AnyCut)                                                    \
  HWY_EXPORT(Name##_extremes);                                                                     \
  HWY_EXPORT(Name##_extreme);                                                                      \
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
  Scalar extreme_key(const Scalar* block, Index stride, Index count, int dimension,                \
                     const AnyCut& cut, Beyond beyond) {                                           \
    return HWY_DYNAMIC_DISPATCH(Name##_extreme)(block, stride, count, dimension, cut, beyond);     \
  }                                                                                                \
  template <>                                                                                      \
  void keys(const Scalar* block, Index count, int dimension, const AnyCut& cut, Scalar* out) {     \
    HWY_DYNAMIC_DISPATCH(Name##_keys)(block, count, dimension, cut, out);                          \
  }                                                                                                \
  template <>                                                                                      \
  Index places_beyond(const Scalar* block, Index stride, Index count, int dimension,               \
                      const AnyCut& cut, Beyond beyond, Scalar threshold, Index* places) {         \
    return HWY_DYNAMIC_DISPATCH(Name##_places)(block, stride, count, dimension, cut, beyond,       \
                                               threshold, places);                                 \
  }
CCVT_FOR_CUTS(CCVT_DISPATCH_CUT, float, float32)
CCVT_FOR_CUTS(CCVT_DISPATCH_CUT, double, float64)
#undef CCVT_DISPATCH_CUT

}  // namespace ccvt::kernels
#endif

#undef CCVT_FOR_CUTS
