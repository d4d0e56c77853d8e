#include "kernels/about.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/about.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "kernels/scattered.h"

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// So many points by so many queries at a time, as additions to a sum wait for one another, and as
/// a point that lies anywhere is best looked at once.
template <Index kRows, Index kQueries>
HWY_INLINE void about_distances(const float* const* points, Index count, int dimension,
                                const std::array<const float*, kQueries>& query, float* out,
                                std::ptrdiff_t stride) {
  const hn::ScalableTag<float> tag;
  const auto lanes = static_cast<int>(hn::Lanes(tag));
  const int whole = dimension / lanes * lanes;
  const auto add = [&](auto& sum, const auto& x, const auto& at) HWY_ATTR {
    const auto difference = hn::Sub(x, at);
    sum = hn::MulAdd(difference, difference, sum);
  };
  static_assert(kRows * kQueries == 4 || kRows * kQueries == 8);
  for (Index k = 0; k < count; k += kRows) {
    const auto row = rows_from<kRows>(points, k, count, dimension);
    std::array<float, std::size_t{kRows} * kQueries> sum{};
    if constexpr (kQueries == 1) {
      auto s0 = hn::Zero(tag);
      auto s1 = s0;
      auto s2 = s0;
      auto s3 = s0;
      for (std::ptrdiff_t d = 0; d < whole; d += lanes) {
        const auto at = hn::LoadU(tag, query[0] + d);
        add(s0, hn::LoadU(tag, row[0] + d), at);
        add(s1, hn::LoadU(tag, row[1] + d), at);
        add(s2, hn::LoadU(tag, row[2] + d), at);
        add(s3, hn::LoadU(tag, row[3] + d), at);
      }
      sum = {hn::GetLane(hn::SumOfLanes(tag, s0)), hn::GetLane(hn::SumOfLanes(tag, s1)),
             hn::GetLane(hn::SumOfLanes(tag, s2)), hn::GetLane(hn::SumOfLanes(tag, s3))};
    } else {
      auto a0 = hn::Zero(tag);
      auto a1 = a0;
      auto a2 = a0;
      auto a3 = a0;
      auto b0 = a0;
      auto b1 = a0;
      auto b2 = a0;
      auto b3 = a0;
      for (std::ptrdiff_t d = 0; d < whole; d += lanes) {
        const auto x = hn::LoadU(tag, row[0] + d);
        const auto y = hn::LoadU(tag, row[1] + d);
        const auto add_both = [&](auto& a, auto& b, const float* at) HWY_ATTR {
          const auto from = hn::LoadU(tag, at + d);
          add(a, x, from);
          add(b, y, from);
        };
        add_both(a0, b0, query[0]);
        add_both(a1, b1, query[1]);
        add_both(a2, b2, query[2]);
        add_both(a3, b3, query[3]);
      }
      sum = {hn::GetLane(hn::SumOfLanes(tag, a0)), hn::GetLane(hn::SumOfLanes(tag, a1)),
             hn::GetLane(hn::SumOfLanes(tag, a2)), hn::GetLane(hn::SumOfLanes(tag, a3)),
             hn::GetLane(hn::SumOfLanes(tag, b0)), hn::GetLane(hn::SumOfLanes(tag, b1)),
             hn::GetLane(hn::SumOfLanes(tag, b2)), hn::GetLane(hn::SumOfLanes(tag, b3))};
    }
    for (Index r = 0; r < std::min(kRows, count - k); ++r) {
      for (Index q = 0; q < kQueries; ++q) {
        float square = sum.data()[r * kQueries + q];
        for (int d = whole; d < dimension; ++d) {
          const float difference = row.data()[r][d] - query.data()[q][d];
          square += difference * difference;
        }
        out[q * stride + k + r] = square;
      }
    }
  }
}

void about_distances_of(const float* const* points, Index count, int dimension,
                        const float* const* query, Index queries, float* out, Index stride) {
  std::ptrdiff_t q = 0;
  for (; q + 4 <= queries; q += 4) {
    about_distances<2, 4>(points, count, dimension,
                          std::array{query[q], query[q + 1], query[q + 2], query[q + 3]},
                          out + q * stride, stride);
  }
  for (; q < queries; ++q) {
    about_distances<4, 1>(points, count, dimension, std::array{query[q]}, out + q * stride, stride);
  }
}

/// Four vectors at a time, likewise. Mul and Add are kept apart, so that no bit depends on the
/// instruction set.
void about_packed(const float* query, const float* positions, Index packs, int dimension,
                  float* out) {
  const hn::CappedTag<float, kFloatPack / 4> tag;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(tag));
  for (std::ptrdiff_t pack = 0; pack < packs; ++pack, out += kFloatPack) {
    for (std::ptrdiff_t l = 0; l < kFloatPack; l += 4 * lanes) {
      auto s0 = hn::Zero(tag);
      auto s1 = s0;
      auto s2 = s0;
      auto s3 = s0;
      const float* x = positions + pack * kFloatPack * dimension + l;
      for (std::ptrdiff_t d = 0; d < dimension; ++d, x += kFloatPack) {
        const auto at = hn::Set(tag, query[d]);
        const auto add = [&](auto& sum, const float* from) HWY_ATTR {
          const auto difference = hn::Sub(hn::LoadU(tag, from), at);
          sum = hn::Add(sum, hn::Mul(difference, difference));
        };
        add(s0, x);
        add(s1, x + lanes);
        add(s2, x + 2 * lanes);
        add(s3, x + 3 * lanes);
      }
      hn::StoreU(s0, tag, out + l);
      hn::StoreU(s1, tag, out + l + lanes);
      hn::StoreU(s2, tag, out + l + 2 * lanes);
      hn::StoreU(s3, tag, out + l + 3 * lanes);
    }
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

HWY_EXPORT(about_distances_of);
void about_squared_distances_of(const float* const* points, Index count, int dimension,
                                const float* const* query, Index queries, float* out,
                                Index stride) {
  HWY_DYNAMIC_DISPATCH(about_distances_of)(points, count, dimension, query, queries, out, stride);
}

HWY_EXPORT(about_packed);
void about_squared_distances(const float* query, const float* positions, Index packs, int dimension,
                             float* out) {
  HWY_DYNAMIC_DISPATCH(about_packed)(query, positions, packs, dimension, out);
}

}  // namespace ccvt::kernels
#endif
