#include "kernels/nearest.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "kernels/nearest.cpp"
#include <hwy/foreach_target.h>
// After foreach_target.h, as Highway asks.
#include <hwy/cache_control.h>
#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <type_traits>

#include "geometry/metric.h"
#include "kernels/scattered.h"

HWY_BEFORE_NAMESPACE();
namespace ccvt::kernels {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Eight interleaved partial sums whatever the vector width, so that bits do not depend on it.
constexpr int kPartials = 8;

/// Sizes of differences, as they are.
struct Straight {
  double operator()(double difference, int) const { return std::abs(difference); }
};

/// Sizes of the shortest differences on a torus.
struct Around {
  const double* extent;
  double operator()(double difference, int d) const {
    return shortest_distance(difference, extent[d]);
  }
};

/// A position is left as soon as the dimensions seen so far put it beyond the best.
template <class Size>
HWY_INLINE double squared_distance_up_to(const double* a, const double* b, int dimension,
                                         double limit, Size size) {
  std::array<double, kPartials> part{};
  double sum = 0;
  int d = 0;
  while (d + kPartials <= dimension) {
    const int stop = std::min(dimension - kPartials, d + 3 * kPartials);
    for (; d <= stop; d += kPartials) {
      for (int l = 0; l < kPartials; ++l) {
        const double difference = size(a[d + l] - b[d + l], d + l);
        part.data()[l] += difference * difference;
      }
    }
    sum = ((part[0] + part[4]) + (part[1] + part[5])) + ((part[2] + part[6]) + (part[3] + part[7]));
    if (sum > limit) return sum;
  }
  for (; d < dimension; ++d) {
    const double difference = size(a[d] - b[d], d);
    sum += difference * difference;
  }
  return sum;
}

template <class Size>
HWY_INLINE Index nearest_by(const double* query, const double* positions, Index count,
                            int dimension, Size size) {
  double best = std::numeric_limits<double>::infinity();
  Index nearest = 0;
  for (Index k = 0; k < count; ++k, positions += dimension) {
    const double squared = squared_distance_up_to(query, positions, dimension, best, size);
    if (squared < best) {
      best = squared;
      nearest = k;
    }
  }
  return nearest;
}

Index nearest_of(const double* query, const double* positions, Index count, int dimension,
                 const double* extent) {
  return extent != nullptr ? nearest_by(query, positions, count, dimension, Around{extent})
                           : nearest_by(query, positions, count, dimension, Straight{});
}

/// The squared distances of a vector of points to a position. Mul and Add are kept apart, as fused
/// ones would change bits between instruction sets.
template <class Tag, class Dimension>
HWY_INLINE hn::Vec<Tag> squared_distances(Tag tag, Dimension dimension, const double* points,
                                          Index stride, const double* position) {
  auto squared = hn::Zero(tag);
  for (std::ptrdiff_t d = 0; d < dimension; ++d) {
    const auto x = hn::LoadU(tag, points + d * stride);
    const auto difference = hn::Sub(x, hn::Set(tag, position[d]));
    squared = hn::Add(squared, hn::Mul(difference, difference));
  }
  return squared;
}

/// Two vectors of points at a time, as each waits for its own last comparison.
template <class Dimension>
HWY_INLINE void nearest_of_few(const double* points, Index stride, Dimension dimension,
                               const double* positions, Index count, std::int32_t* nearest) {
  const hn::CappedTag<double, kNearestPoints / 2> tag;
  const hn::Rebind<std::int32_t, decltype(tag)> whole;
  const auto lanes = static_cast<Index>(hn::Lanes(tag));
  for (Index k = 0; k < stride; k += 2 * lanes) {
    auto best0 = hn::Set(tag, std::numeric_limits<double>::infinity());
    auto best1 = best0;
    auto which0 = hn::Zero(tag);
    auto which1 = which0;
    const double* position = positions;
    for (Index c = 0; c < count; ++c, position += dimension) {
      const auto number = hn::Set(tag, c);
      const auto squared0 = squared_distances(tag, dimension, points + k, stride, position);
      const auto squared1 = squared_distances(tag, dimension, points + k + lanes, stride, position);
      which0 = hn::IfThenElse(hn::Lt(squared0, best0), number, which0);
      which1 = hn::IfThenElse(hn::Lt(squared1, best1), number, which1);
      best0 = hn::Min(squared0, best0);
      best1 = hn::Min(squared1, best1);
    }
    hn::StoreU(hn::DemoteTo(whole, which0), whole, nearest + k);
    hn::StoreU(hn::DemoteTo(whole, which1), whole, nearest + k + lanes);
  }
}

void nearest_of_each(const double* points, Index stride, int dimension, const double* positions,
                     Index count, std::int32_t* nearest) {
  if (dimension == 2) {
    nearest_of_few(points, stride, std::integral_constant<int, 2>{}, positions, count, nearest);
  } else {
    nearest_of_few(points, stride, std::integral_constant<int, 3>{}, positions, count, nearest);
  }
}

/// Of each vector of a pack the shortest differences, one dimension after the other.
template <class Turn>
HWY_INLINE void packed_distances(const double* query, const double* positions, Index packs,
                                 int dimension, double* out, Turn turn) {
  const hn::CappedTag<double, kPack> tag;
  const auto lanes = static_cast<Index>(hn::Lanes(tag));
  const std::ptrdiff_t size = std::ptrdiff_t{kPack} * dimension;
  // Two packs at a time, so that additions need not wait for one another.
  constexpr std::ptrdiff_t kTogether = 2;
  for (std::ptrdiff_t pack = 0; pack < packs;
       pack += kTogether, positions += kTogether * size, out += kTogether * kPack) {
    const std::ptrdiff_t next = pack + 1 < packs ? 1 : 0;
    for (Index l = 0; l < kPack; l += lanes) {
      auto first = hn::Zero(tag);
      auto second = first;
      const double* position = positions + l;
      for (std::ptrdiff_t d = 0; d < dimension; ++d, position += kPack) {
        const auto at = hn::Set(tag, query[d]);
        const auto a = turn(tag, hn::Sub(at, hn::LoadU(tag, position)), d);
        const auto b = turn(tag, hn::Sub(at, hn::LoadU(tag, position + next * size)), d);
        first = hn::Add(first, hn::Mul(a, a));
        second = hn::Add(second, hn::Mul(b, b));
      }
      hn::StoreU(first, tag, out + l);
      hn::StoreU(second, tag, out + next * kPack + l);
    }
  }
}

/// Queries that positions are read once for.
constexpr Index kQueries = 4;

/// The same for kQueries of them, without a torus.
HWY_INLINE void packed_distances_of_few(const double* const* queries, const double* positions,
                                        Index packs, int dimension, double* const* out) {
  const hn::CappedTag<double, kPack> tag;
  const auto lanes = static_cast<Index>(hn::Lanes(tag));
  const double *const q0 = queries[0], *const q1 = queries[1];
  const double *const q2 = queries[2], *const q3 = queries[3];
  const std::ptrdiff_t end = std::ptrdiff_t{packs} * kPack;
  for (std::ptrdiff_t first = 0; first < end; first += kPack, positions += kPack * dimension) {
    for (Index l = 0; l < kPack; l += lanes) {
      auto a0 = hn::Zero(tag), a1 = a0, a2 = a0, a3 = a0;
      const double* position = positions + l;
      for (std::ptrdiff_t d = 0; d < dimension; ++d, position += kPack) {
        const auto at = hn::LoadU(tag, position);
        const auto add = [&](auto& sum, const double* query) HWY_ATTR {
          const auto difference = hn::Sub(hn::Set(tag, query[d]), at);
          sum = hn::Add(sum, hn::Mul(difference, difference));
        };
        add(a0, q0);
        add(a1, q1);
        add(a2, q2);
        add(a3, q3);
      }
      hn::StoreU(a0, tag, out[0] + first + l);
      hn::StoreU(a1, tag, out[1] + first + l);
      hn::StoreU(a2, tag, out[2] + first + l);
      hn::StoreU(a3, tag, out[3] + first + l);
    }
  }
}

/// As many vectors as there are to eight sums, of three points at a time.
template <class Scalar>
HWY_INLINE void distances_of(const Scalar* const* points, Index count, int dimension,
                             const double* query, double* out) {
  const hn::CappedTag<double, kPartials> tag;
  const hn::Rebind<Scalar, decltype(tag)> from;
  const auto lanes = static_cast<Index>(hn::Lanes(tag));
  const int whole = dimension / kPartials * kPartials;
  constexpr Index kRows = 3;
  const auto squared_to = [&](auto& sum, const Scalar* x, const auto& at) HWY_ATTR {
    const auto values = hn::LoadU(from, x);
    auto difference = hn::Zero(tag);
    if constexpr (std::is_same_v<Scalar, float>) {
      difference = hn::Sub(hn::PromoteTo(tag, values), at);
    } else {
      difference = hn::Sub(values, at);
    }
    sum = hn::Add(sum, hn::Mul(difference, difference));
  };
  for (Index k = 0; k < count; k += kRows) {
    const auto row = rows_from<kRows>(points, k, count, dimension);
    std::array<std::array<double, kPartials>, kRows> part;  // set below
    for (Index l = 0; l < kPartials; l += lanes) {
      auto a = hn::Zero(tag);
      auto b = a;
      auto c = a;
      for (std::ptrdiff_t d = l; d < whole; d += kPartials) {
        const auto at = hn::LoadU(tag, query + d);
        squared_to(a, row[0] + d, at);
        squared_to(b, row[1] + d, at);
        squared_to(c, row[2] + d, at);
      }
      hn::StoreU(a, tag, part[0].data() + l);
      hn::StoreU(b, tag, part[1].data() + l);
      hn::StoreU(c, tag, part[2].data() + l);
    }
    for (Index r = 0; r < std::min(kRows, count - k); ++r) {
      const std::array<double, kPartials>& p = part.data()[r];
      double sum = ((p[0] + p[4]) + (p[1] + p[5])) + ((p[2] + p[6]) + (p[3] + p[7]));
      for (int d = whole; d < dimension; ++d) {
        const double to = row.data()[r][d];
        const double difference = to - query[d];
        sum += difference * difference;
      }
      out[k + r] = sum;
    }
  }
}

void float32_distances(const float* const* points, Index count, int dimension, const double* query,
                       double* out) {
  distances_of(points, count, dimension, query, out);
}

void float64_distances(const double* const* points, Index count, int dimension, const double* query,
                       double* out) {
  distances_of(points, count, dimension, query, out);
}

void packed(const double* query, const double* positions, Index packs, int dimension,
            const double* extent, double* out) {
  if (extent == nullptr) {
    return packed_distances(query, positions, packs, dimension, out,
                            [](auto, auto difference, std::ptrdiff_t)
                                HWY_ATTR { return difference; });
  }
  packed_distances(query, positions, packs, dimension, out,
                   [extent](auto tag, auto difference, std::ptrdiff_t d) HWY_ATTR {
                     const auto size = hn::Abs(difference);
                     return hn::Min(size, hn::Abs(hn::Sub(hn::Set(tag, extent[d]), size)));
                   });
}

void packed_for_each(const double* const* queries, Index count, const double* positions,
                     Index packs, int dimension, const double* extent, double* const* out) {
  Index k = 0;
  for (; extent == nullptr && k + kQueries <= count; k += kQueries) {
    packed_distances_of_few(queries + k, positions, packs, dimension, out + k);
  }
  for (; k < count; ++k) packed(queries[k], positions, packs, dimension, extent, out[k]);
}

}  // namespace HWY_NAMESPACE
}  // namespace ccvt::kernels
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ccvt::kernels {

HWY_EXPORT(nearest_of);
Index nearest_position(const double* query, const double* positions, Index count, int dimension,
                       const double* extent) {
  return HWY_DYNAMIC_DISPATCH(nearest_of)(query, positions, count, dimension, extent);
}

HWY_EXPORT(nearest_of_each);
void nearest_positions(const double* points, Index stride, int dimension, const double* positions,
                       Index count, std::int32_t* nearest) {
  HWY_DYNAMIC_DISPATCH(nearest_of_each)(points, stride, dimension, positions, count, nearest);
}

HWY_EXPORT(packed);
void squared_distances(const double* query, const double* positions, Index packs, int dimension,
                       const double* extent, double* out) {
  HWY_DYNAMIC_DISPATCH(packed)(query, positions, packs, dimension, extent, out);
}

HWY_EXPORT(packed_for_each);
void squared_distances(const double* const* queries, Index count, const double* positions,
                       Index packs, int dimension, const double* extent, double* const* out) {
  HWY_DYNAMIC_DISPATCH(packed_for_each)(queries, count, positions, packs, dimension, extent, out);
}

HWY_EXPORT(float32_distances);
HWY_EXPORT(float64_distances);

template <>
void squared_distances_of(const float* const* points, Index count, int dimension,
                          const double* query, double* out) {
  HWY_DYNAMIC_DISPATCH(float32_distances)(points, count, dimension, query, out);
}

template <>
void squared_distances_of(const double* const* points, Index count, int dimension,
                          const double* query, double* out) {
  HWY_DYNAMIC_DISPATCH(float64_distances)(points, count, dimension, query, out);
}

}  // namespace ccvt::kernels
#endif
