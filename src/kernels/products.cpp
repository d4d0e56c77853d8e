#include "kernels/products.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/products.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <type_traits>

#include "kernels/rows.h"

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Where there are no vectors, as many all the same as rows are turned into streams at a time.
Index points_of_products() {
  return std::max(kRowGroup, 2 * static_cast<Index>(hn::Lanes(hn::ScalableTag<float>())));
}

/// Two vectors of points by six sites stay in registers.
template <class Dimension>
HWY_INLINE void costs(const float* block, Index stride, Dimension dimension, const float* v,
                      const float* constant, Index sites, float* cost, float* lowest) {
  const hn::ScalableTag<float> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  for (std::ptrdiff_t s = 0; s < sites; s += kCostSites) {
    const float* site = v + s * dimension;
    float* row = cost + s * stride;
    for (Index k = 0; k < stride; k += 2 * lanes) {
      auto a0 = hn::Set(wide, constant[s]), b0 = a0;
      auto a1 = hn::Set(wide, constant[s + 1]), b1 = a1;
      auto a2 = hn::Set(wide, constant[s + 2]), b2 = a2;
      auto a3 = hn::Set(wide, constant[s + 3]), b3 = a3;
      auto a4 = hn::Set(wide, constant[s + 4]), b4 = a4;
      auto a5 = hn::Set(wide, constant[s + 5]), b5 = a5;
      const float* x = block + k;
      for (int d = 0; d < dimension; ++d, x += stride) {
        const auto xa = hn::LoadU(wide, x);
        const auto xb = hn::LoadU(wide, x + lanes);
        const auto subtract = [&](auto& a, auto& b, std::ptrdiff_t which) HWY_ATTR {
          const auto y = hn::Set(wide, site[which * dimension + d]);
          a = hn::NegMulAdd(xa, y, a);
          b = hn::NegMulAdd(xb, y, b);
        };
        subtract(a0, b0, 0);
        subtract(a1, b1, 1);
        subtract(a2, b2, 2);
        subtract(a3, b3, 3);
        subtract(a4, b4, 4);
        subtract(a5, b5, 5);
      }
      float* out = row + k;
      auto la = hn::LoadU(wide, lowest + k);
      auto lb = hn::LoadU(wide, lowest + k + lanes);
      const auto keep = [&](const auto& a, const auto& b) HWY_ATTR {
        hn::StoreU(a, wide, out);
        hn::StoreU(b, wide, out + lanes);
        la = hn::Min(la, a);
        lb = hn::Min(lb, b);
        out += stride;
      };
      keep(a0, b0);
      keep(a1, b1);
      keep(a2, b2);
      keep(a3, b3);
      keep(a4, b4);
      keep(a5, b5);
      hn::StoreU(la, wide, lowest + k);
      hn::StoreU(lb, wide, lowest + k + lanes);
    }
  }
}

/// Lets the compiler unroll the loop over dimensions in the common cases.
void costs_of_sites(const float* block, Index stride, int dimension, const float* v,
                    const float* constant, Index sites, float* cost, float* lowest) {
  if (dimension == 2) {
    costs(block, stride, std::integral_constant<int, 2>{}, v, constant, sites, cost, lowest);
  } else if (dimension == 3) {
    costs(block, stride, std::integral_constant<int, 3>{}, v, constant, sites, cost, lowest);
  } else {
    costs(block, stride, dimension, v, constant, sites, cost, lowest);
  }
}

Index places_within(const float* cost, Index stride, Index rows, const float* limit,
                    Index* places) {
  const hn::ScalableTag<float> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  Index found = 0;
  for (Index place = 0, row = 0; row < rows; ++row) {
    for (Index k = 0; k < stride; k += lanes, place += lanes) {
      const auto mask = hn::Le(hn::LoadU(wide, cost + place), hn::LoadU(wide, limit + k));
      if (hn::AllFalse(wide, mask)) continue;
      for (Index l = 0; l < lanes; ++l) {
        places[found] = place + l;
        found += cost[place + l] <= limit[k + l] ? 1 : 0;
      }
    }
  }
  return found;
}

void rows_least(const float* cost, Index stride, Index rows, float* least) {
  const hn::ScalableTag<float> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  for (Index row = 0; row < rows; ++row) {
    auto a = hn::LoadU(wide, cost);
    for (Index k = lanes; k < stride; k += lanes) a = hn::Min(a, hn::LoadU(wide, cost + k));
    least[row] = hn::GetLane(hn::MinOfLanes(wide, a));
    cost += stride;
  }
}

template <class Tag>
HWY_INLINE hn::Vec<Tag> square_to(Tag tag, const float* block, Index stride, int dimension,
                                  const float* q, Index k) {
  auto sum = hn::Zero(tag);
  const float* x = block + k;
  for (int d = 0; d < dimension; ++d, x += stride) {
    const auto difference = hn::Sub(hn::LoadU(tag, x), hn::Set(tag, q[d]));
    sum = hn::Add(sum, hn::Mul(difference, difference));
  }
  return sum;
}

void squares_lowered(const float* block, Index stride, int dimension, const float* q,
                     float* squared) {
  const hn::ScalableTag<float> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  for (Index k = 0; k < stride; k += lanes) {
    const auto square = square_to(wide, block, stride, dimension, q, k);
    hn::StoreU(hn::Min(square, hn::LoadU(wide, squared + k)), wide, squared + k);
  }
}

/// In eight interleaved parts whatever the vector width, so that bits do not depend on it.
void sums_lowered(const float* block, Index stride, Index count, int dimension, const float* q,
                  const float* squared, double* sums) {
  const hn::ScalableTag<float> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  std::array<float, kSumPoints> value{};
  for (Index begin = 0; begin < count; begin += kSumPoints) {
    const Index size = std::min(kSumPoints, count - begin);
    for (Index k = 0; k < size; k += lanes) {
      const auto square = square_to(wide, block, stride, dimension, q, begin + k);
      hn::StoreU(hn::Min(square, hn::LoadU(wide, squared + begin + k)), wide, value.data() + k);
    }
    std::array<float, 8> sum{};
    for (Index k = 0; k < size; ++k) sum.data()[k % 8] += value.data()[k];
    const double first = (sum[0] + sum[4]) + (sum[1] + sum[5]);
    const double second = (sum[2] + sum[6]) + (sum[3] + sum[7]);
    *sums++ = first + second;
  }
}

/// Two vectors of points by six sites stay in registers.
template <class Scalar>
HWY_INLINE void dots(const Scalar* block, Index stride, int dimension, const Scalar* offset,
                     const Scalar* sites, Index site_count, Scalar* largest) {
  const hn::ScalableTag<Scalar> wide;
  const auto lanes = static_cast<Index>(hn::Lanes(wide));
  for (std::ptrdiff_t s = 0; s < site_count; s += kDotSites) {
    const Scalar* site = sites + s * dimension;
    const auto lowest = hn::Set(wide, std::numeric_limits<Scalar>::lowest());
    auto m0 = lowest, m1 = lowest, m2 = lowest, m3 = lowest, m4 = lowest, m5 = lowest;
    for (Index k = 0; k < stride; k += 2 * lanes) {
      const auto zero = hn::Zero(wide);
      auto a0 = zero, a1 = zero, a2 = zero, a3 = zero, a4 = zero, a5 = zero;
      auto b0 = zero, b1 = zero, b2 = zero, b3 = zero, b4 = zero, b5 = zero;
      const Scalar* x = block + k;
      for (int d = 0; d < dimension; ++d, x += stride) {
        const auto xa = hn::LoadU(wide, x);
        const auto xb = hn::LoadU(wide, x + lanes);
        const auto add = [&](auto& a, auto& b, std::ptrdiff_t which) HWY_ATTR {
          const auto y = hn::Set(wide, site[which * dimension + d]);
          a = hn::MulAdd(xa, y, a);
          b = hn::MulAdd(xb, y, b);
        };
        add(a0, b0, 0);
        add(a1, b1, 1);
        add(a2, b2, 2);
        add(a3, b3, 3);
        add(a4, b4, 4);
        add(a5, b5, 5);
      }
      const auto oa = hn::LoadU(wide, offset + k);
      const auto ob = hn::LoadU(wide, offset + k + lanes);
      const auto keep = [&](auto& m, const auto& a, const auto& b)
                            HWY_ATTR { m = hn::Max(m, hn::Max(hn::Sub(a, oa), hn::Sub(b, ob))); };
      keep(m0, a0, b0);
      keep(m1, a1, b1);
      keep(m2, a2, b2);
      keep(m3, a3, b3);
      keep(m4, a4, b4);
      keep(m5, a5, b5);
    }
    largest[s] = hn::GetLane(hn::MaxOfLanes(wide, m0));
    largest[s + 1] = hn::GetLane(hn::MaxOfLanes(wide, m1));
    largest[s + 2] = hn::GetLane(hn::MaxOfLanes(wide, m2));
    largest[s + 3] = hn::GetLane(hn::MaxOfLanes(wide, m3));
    largest[s + 4] = hn::GetLane(hn::MaxOfLanes(wide, m4));
    largest[s + 5] = hn::GetLane(hn::MaxOfLanes(wide, m5));
  }
}

void float32_dots(const float* block, Index stride, int dimension, const float* offset,
                  const float* sites, Index site_count, float* largest) {
  dots(block, stride, dimension, offset, sites, site_count, largest);
}

void float64_dots(const double* block, Index stride, int dimension, const double* offset,
                  const double* sites, Index site_count, double* largest) {
  dots(block, stride, dimension, offset, sites, site_count, largest);
}

Index float64_points() { return 2 * static_cast<Index>(hn::Lanes(hn::ScalableTag<double>())); }

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

HWY_EXPORT(points_of_products);
HWY_EXPORT(costs_of_sites);
HWY_EXPORT(places_within);
HWY_EXPORT(rows_least);
HWY_EXPORT(squares_lowered);
HWY_EXPORT(sums_lowered);

Index product_points() { return HWY_DYNAMIC_DISPATCH(points_of_products)(); }

void site_costs(const float* block, Index stride, int dimension, const float* v,
                const float* constant, Index sites, float* cost, float* lowest) {
  HWY_DYNAMIC_DISPATCH(costs_of_sites)
  (block, stride, dimension, v, constant, sites, cost, lowest);
}

Index costs_within(const float* cost, Index stride, Index rows, const float* limit, Index* places) {
  return HWY_DYNAMIC_DISPATCH(places_within)(cost, stride, rows, limit, places);
}

void least_costs(const float* cost, Index stride, Index rows, float* least) {
  HWY_DYNAMIC_DISPATCH(rows_least)(cost, stride, rows, least);
}

void lower_squares(const float* block, Index stride, int dimension, const float* q,
                   float* squared) {
  HWY_DYNAMIC_DISPATCH(squares_lowered)(block, stride, dimension, q, squared);
}

void lowered_sums(const float* block, Index stride, Index count, int dimension, const float* q,
                  const float* squared, double* sums) {
  HWY_DYNAMIC_DISPATCH(sums_lowered)(block, stride, count, dimension, q, squared, sums);
}

HWY_EXPORT(float32_dots);
HWY_EXPORT(float64_dots);
HWY_EXPORT(float64_points);

template <>
void largest_dots(const float* block, Index stride, int dimension, const float* offset,
                  const float* sites, Index site_count, float* largest) {
  HWY_DYNAMIC_DISPATCH(float32_dots)
  (block, stride, dimension, offset, sites, site_count, largest);
}

template <>
void largest_dots(const double* block, Index stride, int dimension, const double* offset,
                  const double* sites, Index site_count, double* largest) {
  HWY_DYNAMIC_DISPATCH(float64_dots)
  (block, stride, dimension, offset, sites, site_count, largest);
}

template <>
Index dot_points<float>() {
  return product_points();
}

template <>
Index dot_points<double>() {
  return HWY_DYNAMIC_DISPATCH(float64_points)();
}

}  // namespace ccvt::kernels
#endif
