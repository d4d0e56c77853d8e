#include "kernels/rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/rows.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A line of floats in memory.
constexpr std::ptrdiff_t kLine = 16;
using Line = std::array<float, kLine>;

/// A line of a row, from `x` on, relative to the centre, from `from` on.
template <class Scalar>
HWY_INLINE void centre(const Scalar* x, const double* from, double scale, Line& line) {
  const hn::CappedTag<double, kLine> wide;
  const hn::Rebind<float, decltype(wide)> narrow;
  const auto factor = hn::Set(wide, scale);
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(wide));
  for (std::ptrdiff_t l = 0; l < kLine; l += lanes) {
    auto value = hn::Zero(wide);
    if constexpr (std::is_same_v<Scalar, float>) {
      value = hn::PromoteTo(wide, hn::LoadU(narrow, x + l));
    } else {
      value = hn::LoadU(wide, x + l);
    }
    const auto centred = hn::Mul(hn::Sub(value, hn::LoadU(wide, from + l)), factor);
    hn::StoreU(hn::DemoteTo(narrow, centred), narrow, line.data() + l);
  }
}

/// Four lines, from place `l` on, as four streams.
HWY_INLINE void turn(const Line* lines, std::ptrdiff_t l, float* to, std::ptrdiff_t stride) {
#if HWY_TARGET == HWY_SCALAR
  for (std::ptrdiff_t d = 0; d < 4; ++d) {
    for (std::ptrdiff_t r = 0; r < 4; ++r) to[d * stride + r] = lines[r].data()[l + d];
  }
#else
  const hn::FixedTag<float, 4> four;
  const auto a = hn::LoadU(four, lines[0].data() + l);
  const auto b = hn::LoadU(four, lines[1].data() + l);
  const auto c = hn::LoadU(four, lines[2].data() + l);
  const auto d = hn::LoadU(four, lines[3].data() + l);
  const auto ab = hn::InterleaveLower(four, a, b);
  const auto cd = hn::InterleaveLower(four, c, d);
  const auto upper_ab = hn::InterleaveUpper(four, a, b);
  const auto upper_cd = hn::InterleaveUpper(four, c, d);
  hn::StoreU(hn::ConcatLowerLower(four, cd, ab), four, to);
  hn::StoreU(hn::ConcatUpperUpper(four, cd, ab), four, to + stride);
  hn::StoreU(hn::ConcatLowerLower(four, upper_cd, upper_ab), four, to + 2 * stride);
  hn::StoreU(hn::ConcatUpperUpper(four, upper_cd, upper_ab), four, to + 3 * stride);
#endif
}

template <class Scalar>
HWY_INLINE void centred_streams(const Scalar* const* rows, Index count, Index width, int dimension,
                                const double* centre_of, double scale, float* block,
                                std::ptrdiff_t stride) {
  constexpr std::ptrdiff_t kScalarLine = 64 / sizeof(Scalar);
  std::array<Line, kRowGroup> lines{};
  const auto group = [&](std::ptrdiff_t k) {
    std::array<const Scalar*, kRowGroup> row{};
    for (Index r = 0; r < kRowGroup; ++r) {
      row.data()[r] = rows[std::min<std::ptrdiff_t>(k + r, count - 1)];
    }
    return row;
  };
  for (std::ptrdiff_t k = 0; k < width; k += kRowGroup) {
    const auto here = group(k);
    const auto next = group(k + kRowGroup);
    std::ptrdiff_t d = 0;
    for (; d + kLine <= dimension; d += kLine) {
      for (std::size_t r = 0; r < lines.size(); ++r) {
        for (std::ptrdiff_t ahead = 0; ahead < kLine; ahead += kScalarLine) {
          hwy::Prefetch(next.data()[r] + d + ahead);
        }
        centre(here.data()[r] + d, centre_of + d, scale, lines.data()[r]);
      }
      for (std::ptrdiff_t l = 0; l < kLine; l += 4) {
        float* const to = block + (d + l) * stride + k;
        for (std::ptrdiff_t r = 0; r < kRowGroup; r += 4) turn(lines.data() + r, l, to + r, stride);
      }
    }
    for (; d < dimension; ++d) {
      float* const to = block + d * stride + k;
      for (std::ptrdiff_t r = 0; r < kRowGroup; ++r) {
        to[r] = static_cast<float>((here.data()[r][d] - centre_of[d]) * scale);
      }
    }
  }
}

void rows_of_float(const float* const* rows, Index count, Index width, int dimension,
                   const double* centre_of, double scale, float* block, Index stride) {
  centred_streams(rows, count, width, dimension, centre_of, scale, block, stride);
}

void rows_of_double(const double* const* rows, Index count, Index width, int dimension,
                    const double* centre_of, double scale, float* block, Index stride) {
  centred_streams(rows, count, width, dimension, centre_of, scale, block, stride);
}

void points_of_double(const double* const* rows, Index count, int dimension,
                      const double* centre_of, double scale, float* block) {
  const hn::ScalableTag<double> wide;
  const hn::Rebind<float, decltype(wide)> narrow;
  const auto factor = hn::Set(wide, scale);
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(wide));
  for (std::ptrdiff_t k = 0; k < count; ++k, block += dimension) {
    const double* const x = rows[k];
    std::ptrdiff_t d = 0;
    for (; d + lanes <= dimension; d += lanes) {
      const auto from_centre = hn::Sub(hn::LoadU(wide, x + d), hn::LoadU(wide, centre_of + d));
      hn::StoreU(hn::DemoteTo(narrow, hn::Mul(from_centre, factor)), narrow, block + d);
    }
    for (; d < dimension; ++d) block[d] = static_cast<float>((x[d] - centre_of[d]) * scale);
  }
}

/// A vector of a row, in double.
template <class Tag, class Scalar>
HWY_INLINE hn::Vec<Tag> load(Tag wide, const Scalar* x) {
  if constexpr (std::is_same_v<Scalar, float>) {
    const hn::Rebind<float, Tag> narrow;
    return hn::PromoteTo(wide, hn::LoadU(narrow, x));
  } else {
    return hn::LoadU(wide, x);
  }
}

/// Four rows at a time, so that sums are loaded and stored once for them.
template <class Scalar>
HWY_INLINE void add_all(const Scalar* const* rows, Index count, int dimension,
                        const double* centre_of, double* sum) {
  const hn::ScalableTag<double> wide;
  const auto lanes = static_cast<std::ptrdiff_t>(hn::Lanes(wide));
  const auto whole = dimension / lanes * lanes;
  std::ptrdiff_t k = 0;
  for (; k + 4 <= count; k += 4) {
    for (std::ptrdiff_t d = 0; d < whole; d += lanes) {
      const auto from = hn::LoadU(wide, centre_of + d);
      auto to = hn::LoadU(wide, sum + d);
      for (std::ptrdiff_t r = k; r < k + 4; ++r) {
        to = hn::Add(to, hn::Sub(load(wide, rows[r] + d), from));
      }
      hn::StoreU(to, wide, sum + d);
    }
  }
  for (std::ptrdiff_t r = k; r < count; ++r) {
    for (std::ptrdiff_t d = 0; d < whole; d += lanes) {
      const auto here = hn::Sub(load(wide, rows[r] + d), hn::LoadU(wide, centre_of + d));
      hn::StoreU(hn::Add(hn::LoadU(wide, sum + d), here), wide, sum + d);
    }
  }
  for (std::ptrdiff_t r = 0; r < count; ++r) {
    for (std::ptrdiff_t d = whole; d < dimension; ++d) {
      sum[d] += double{rows[r][d]} - centre_of[d];
    }
  }
}

void add_floats(const float* const* rows, Index count, int dimension, const double* centre_of,
                double* sum) {
  add_all(rows, count, dimension, centre_of, sum);
}

void add_doubles(const double* const* rows, Index count, int dimension, const double* centre_of,
                 double* sum) {
  add_all(rows, count, dimension, centre_of, sum);
}

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

HWY_EXPORT(rows_of_float);
HWY_EXPORT(rows_of_double);

template <>
void centred_rows(const float* const* rows, Index count, Index width, int dimension,
                  const double* centre, double scale, float* block, Index stride) {
  HWY_DYNAMIC_DISPATCH(rows_of_float)(rows, count, width, dimension, centre, scale, block, stride);
}

template <>
void centred_rows(const double* const* rows, Index count, Index width, int dimension,
                  const double* centre, double scale, float* block, Index stride) {
  HWY_DYNAMIC_DISPATCH(rows_of_double)(rows, count, width, dimension, centre, scale, block, stride);
}

HWY_EXPORT(points_of_double);
void centred_points(const double* const* rows, Index count, int dimension, const double* centre,
                    double scale, float* block) {
  HWY_DYNAMIC_DISPATCH(points_of_double)(rows, count, dimension, centre, scale, block);
}

HWY_EXPORT(add_floats);
HWY_EXPORT(add_doubles);

template <>
void add_rows(const float* const* rows, Index count, int dimension, const double* centre,
              double* sum) {
  HWY_DYNAMIC_DISPATCH(add_floats)(rows, count, dimension, centre, sum);
}

template <>
void add_rows(const double* const* rows, Index count, int dimension, const double* centre,
              double* sum) {
  HWY_DYNAMIC_DISPATCH(add_doubles)(rows, count, dimension, centre, sum);
}

}  // namespace ccvt::kernels
#endif
