#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "ccvt/sampling.h"
#include "checks.h"
#include "number_text.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "random.h"
#include "sampling/scalar_box.h"
#include "sampling/strata.h"
#include "streams.h"
#include "thread_count.h"

namespace ccvt {
namespace {

// Points that share a random stream. Chunks may be filled in any order.
constexpr std::size_t chunk_points = 4096;
// Fewer are drawn before other threads have started.
constexpr Index points_for_threads = 1 << 18;

template <class Scalar>
struct Fill {
  const Box& box;
  ScalarBox<Scalar> bounds;
  std::size_t dimension;
  Index count;
  Index begin;  // the points that there is room for
  Index end;
  Scalar* coordinates;
  std::ptrdiff_t pitch;  // from one point to the next

  Fill(const Box& b, Index all, Index first, std::span<Scalar> out)
      : box(b),
        bounds(b),
        dimension(bounds.dimension()),
        count(all),
        begin(first),
        end(first + static_cast<Index>(out.size() / dimension)),
        coordinates(out.data()),
        pitch(b.lower.size()) {}

  [[nodiscard]] bool has(Index p) const { return begin <= p && p < end; }
  [[nodiscard]] Scalar* point(Index p) const { return coordinates + (p - begin) * pitch; }

  void white(Random& random, Index first, Index last) const {
    const Eigen::VectorXd extent = box.extent();
    const double* lower = box.lower.data();
    for (Index p = first; p < last; ++p) {
      for (std::size_t d = 0; d < dimension; ++d) {
        const double at = random.uniform();
        if (has(p)) point(p)[d] = bounds.round(d, lower[d] + at * extent.data()[d]);
      }
    }
  }

  void jittered(Random& random, const Strata& strata, Index first, Index last) const {
    strata.visit(box.lower, first, last,
                 [&](Index p, std::span<const double> corner, std::span<const double> size) {
                   for (std::size_t d = 0; d < dimension; ++d) {
                     const double at = random.uniform();
                     if (has(p)) point(p)[d] = bounds.round(d, corner[d] + at * size[d]);
                   }
                 });
  }

  // The places a fraction `at` along the diagonals of the cells, for the points first, first +
  // stride, ...
  void diagonal(const Strata& strata, Index cells, double at, Index first, Index stride) const {
    const Index from = std::max((begin - first) / stride, 0);
    const Index to = std::min(cells, (end - first) / stride + 1);
    strata.visit(box.lower, from, to,
                 [&](Index cell, std::span<const double> corner, std::span<const double> size) {
                   if (!has(first + cell * stride)) return;
                   Scalar* out = point(first + cell * stride);
                   for (std::size_t d = 0; d < dimension; ++d) {
                     out[d] = bounds.round(d, corner[d] + at * size[d]);
                   }
                 });
  }

  void body_centred() const {
    const Index cells = count / 2 + count % 2;
    const Strata strata(box.extent(), cells);
    diagonal(strata, count / 2, 0.25, 0, 2);
    diagonal(strata, count / 2, 0.75, 1, 2);
    if (count % 2 == 1 && has(count - 1)) {
      strata.visit(box.lower, cells - 1, cells,
                   [&](Index, std::span<const double> corner, std::span<const double> size) {
                     for (std::size_t d = 0; d < dimension; ++d) {
                       point(count - 1)[d] = bounds.round(d, corner[d] + 0.5 * size[d]);
                     }
                   });
    }
  }

  // Rows along the first dimension, as thick as their numbers of points, which differ by at most 1.
  void hexagonal() const {
    const Eigen::VectorXd extent = box.extent();
    const double m = count;
    // A hexagonal lattice of spacing a has rows sqrt(3)/2 a apart and area sqrt(3)/2 a^2 a point.
    const double ideal = std::sqrt(m * (extent[1] / extent[0]) / std::sqrt(0.75));
    // An even number, so that rows alternate across the seam of a torus too.
    const double even = ideal < 3 ? std::floor(ideal + 0.5) : 2 * std::floor(ideal / 2 + 0.5);
    const auto rows = static_cast<std::int64_t>(std::clamp(even, 1.0, m));
    const auto begin_of = [&](std::int64_t row) { return static_cast<Index>(row * count / rows); };
    for (std::int64_t row = 0; row < rows; ++row) {
      const Index row_begin = begin_of(row);
      const Index row_end = begin_of(row + 1);
      const double y = box.lower[1] + extent[1] * (0.5 * (1.0 * row_begin + row_end) / m);
      const double shift = rows == 1 ? 0.5 : row % 2 == 0 ? 0.25 : 0.75;
      const double spacing = extent[0] / (row_end - row_begin);
      for (Index k = std::max(row_begin, begin); k < std::min(row_end, end); ++k) {
        Scalar* out = point(k);
        out[0] = bounds.round(0, box.lower[0] + (k - row_begin + shift) * spacing);
        out[1] = bounds.round(1, y);
      }
    }
  }

  void run(std::uint64_t seed, Distribution distribution, int threads) const {
    if (distribution == Distribution::hexagonal && dimension > 1) {
      dimension == 2 ? hexagonal() : body_centred();
      return;
    }
    const Strata strata(box.extent(), count);
    if (distribution == Distribution::square || distribution == Distribution::hexagonal) {
      diagonal(strata, count, 0.5, 0, 1);
      return;
    }
    if (begin == end) return;
    const Arena arena(end - begin < points_for_threads ? 1 : threads);
    const std::size_t first_chunk = PointNumber(begin) / chunk_points;
    const std::size_t chunks = (PointNumber(end) - 1) / chunk_points + 1 - first_chunk;
    arena.for_each(chunks, 1, [&](std::size_t k) {
      const std::size_t chunk = first_chunk + k;
      Random random(seed, streams::uniform + chunk);
      const Index first = PointNumber(chunk * chunk_points).index();
      const Index last =
          PointNumber(std::min((chunk + 1) * chunk_points, std::size_t(PointNumber(end)))).index();
      if (distribution == Distribution::white) {
        white(random, first, last);
      } else {
        jittered(random, strata, first, last);
      }
    });
  }
};

// Lower and upper corner in one dimension.
template <class Scalar>
void check_side(double lower, double upper, Eigen::Index d, const char* scalar) {
  constexpr double greatest = std::numeric_limits<Scalar>::max();
  if (!(std::abs(lower) <= greatest)) {
    throw InvalidInput(concat("box: lower[", d, "] is ", lower,
                              ", but must be finite and within the range of ", scalar));
  }
  if (!(std::abs(upper) <= greatest)) {
    throw InvalidInput(concat("box: upper[", d, "] is ", upper,
                              ", but must be finite and within the range of ", scalar));
  }
  if (!(lower < upper)) {
    throw InvalidInput(concat("box: lower[", d, "] is ", lower, " and upper[", d, "] is ", upper,
                              ", but lower must be less than upper"));
  }
  if (!std::isfinite(upper - lower)) {
    throw InvalidInput(concat("box: lower[", d, "] is ", lower, " and upper[", d, "] is ", upper,
                              ", but the extent must be finite"));
  }
}

template <class Scalar>
void check_box(const Box& box, const char* scalar) {
  for (Eigen::Index d = 0; d < box.lower.size(); ++d) {
    check_side<Scalar>(box.lower[d], box.upper[d], d, scalar);
  }
  const ScalarBox<Scalar> bounds(box);
  for (std::size_t d = 0; d < bounds.dimension(); ++d) {
    if (bounds.empty(d)) {
      throw InvalidInput(concat("box: lower[", d, "] is ", box.lower.data()[d], " and upper[", d,
                                "] is ", box.upper.data()[d], ", but there is no number of type ",
                                scalar, " from one up to the other"));
    }
  }
}

}  // namespace

namespace detail {

void check_sampling(const Box& box, Index count, int fixed_dimension, std::size_t scalar_bytes) {
  if (count < 1) throw InvalidInput(concat("count: is ", count, ", but must be at least 1"));
  const Eigen::Index dimension = box.lower.size();
  require_corners(box);
  if (dimension < 1) throw InvalidInput("box: has 0 dimensions, but must have at least 1");
  if (fixed_dimension != Eigen::Dynamic && dimension != fixed_dimension) {
    throw InvalidInput(concat("box: has ", dimension, " dimensions, but points of ",
                              fixed_dimension, " are asked for"));
  }
  const bool single = scalar_bytes == sizeof(float);
  if (dimension > PTRDIFF_MAX / (single ? 4 : 8) / count) {
    throw InvalidInput(
        concat("count: ", count, " points of ", dimension, " dimensions exceed the address space"));
  }
  single ? check_box<float>(box, "float") : check_box<double>(box, "double");
}

void fill_uniform(const Box& box, std::uint64_t seed, Distribution distribution, int threads,
                  std::span<float> coordinates) {
  fill_uniform_part(box, static_cast<Index>(std::ssize(coordinates) / box.dimension()), 0, seed,
                    distribution, threads, coordinates);
}

void fill_uniform(const Box& box, std::uint64_t seed, Distribution distribution, int threads,
                  std::span<double> coordinates) {
  fill_uniform_part(box, static_cast<Index>(std::ssize(coordinates) / box.dimension()), 0, seed,
                    distribution, threads, coordinates);
}

void fill_uniform_part(const Box& box, Index count, Index first, std::uint64_t seed,
                       Distribution distribution, int threads, std::span<float> coordinates) {
  require_threads(threads);
  require_enumerator("distribution", distribution, Distribution::hexagonal);
  Fill<float>(box, count, first, coordinates).run(seed, distribution, threads);
}

void fill_uniform_part(const Box& box, Index count, Index first, std::uint64_t seed,
                       Distribution distribution, int threads, std::span<double> coordinates) {
  require_threads(threads);
  require_enumerator("distribution", distribution, Distribution::hexagonal);
  Fill<double>(box, count, first, coordinates).run(seed, distribution, threads);
}

}  // namespace detail
}  // namespace ccvt
