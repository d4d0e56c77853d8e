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
constexpr std::int64_t chunk_points = 4096;
// Fewer are drawn before other threads have started.
constexpr Index points_for_threads = 1 << 18;

template <class Scalar>
struct Fill {
  const Box& box;
  ScalarBox<Scalar> bounds;
  std::size_t dimension;
  std::int64_t count;
  std::int64_t begin;  // the points that there is room for
  std::int64_t end;
  Scalar* coordinates;
  std::ptrdiff_t pitch;  // from one point to the next

  Fill(const Box& b, std::int64_t all, std::int64_t first, std::span<Scalar> out)
      : box(b),
        bounds(b),
        dimension(bounds.dimension()),
        count(all),
        begin(first),
        end(first + std::ssize(out) / box.dimension()),
        coordinates(out.data()),
        pitch(b.lower.size()) {}

  [[nodiscard]] bool has(std::int64_t p) const { return begin <= p && p < end; }
  [[nodiscard]] Scalar* point(std::int64_t p) const { return coordinates + (p - begin) * pitch; }

  void white(Random& random, std::int64_t first, std::int64_t last) const {
    const Eigen::VectorXd extent = box.extent();
    const double* lower = box.lower.data();
    for (std::int64_t p = first; p < last; ++p) {
      for (std::size_t d = 0; d < dimension; ++d) {
        const double at = random.uniform();
        if (has(p)) point(p)[d] = bounds.round(d, lower[d] + at * extent.data()[d]);
      }
    }
  }

  void jittered(Random& random, const Strata& strata, std::int64_t first, std::int64_t last) const {
    strata.visit(box.lower, first, last,
                 [&](std::int64_t p, std::span<const double> corner, std::span<const double> size) {
                   for (std::size_t d = 0; d < dimension; ++d) {
                     const double at = random.uniform();
                     if (has(p)) point(p)[d] = bounds.round(d, corner[d] + at * size[d]);
                   }
                 });
  }

  // The places a fraction `at` along the diagonals of the cells, for the points first, first +
  // stride, ...
  void diagonal(const Strata& strata, std::int64_t cells, double at, std::int64_t first,
                std::int64_t stride) const {
    const std::int64_t from = std::max((begin - first) / stride, std::int64_t{0});
    const std::int64_t to = std::min(cells, (end - first) / stride + 1);
    strata.visit(
        box.lower, from, to,
        [&](std::int64_t cell, std::span<const double> corner, std::span<const double> size) {
          if (!has(first + cell * stride)) return;
          Scalar* out = point(first + cell * stride);
          for (std::size_t d = 0; d < dimension; ++d) {
            out[d] = bounds.round(d, corner[d] + at * size[d]);
          }
        });
  }

  void body_centred() const {
    const std::int64_t cells = count / 2 + count % 2;
    const Strata strata(box.extent(), cells);
    diagonal(strata, count / 2, 0.25, 0, 2);
    diagonal(strata, count / 2, 0.75, 1, 2);
    if (count % 2 == 1 && has(count - 1)) {
      strata.visit(box.lower, cells - 1, cells,
                   [&](std::int64_t, std::span<const double> corner, std::span<const double> size) {
                     for (std::size_t d = 0; d < dimension; ++d) {
                       point(count - 1)[d] = bounds.round(d, corner[d] + 0.5 * size[d]);
                     }
                   });
    }
  }

  // Rows along the first dimension, as thick as their numbers of points, which differ by at most 1.
  void hexagonal() const {
    const Eigen::VectorXd extent = box.extent();
    const auto m = static_cast<double>(count);
    // A hexagonal lattice of spacing a has rows sqrt(3)/2 a apart and area sqrt(3)/2 a^2 a point.
    const double ideal = std::sqrt(m * (extent[1] / extent[0]) / std::sqrt(0.75));
    // An even number, so that rows alternate across the seam of a torus too.
    const double even = ideal < 3 ? std::floor(ideal + 0.5) : 2 * std::floor(ideal / 2 + 0.5);
    // So few that no product of a row and the count overflows.
    const auto rows = static_cast<std::int64_t>(std::clamp(even, 1.0, std::min(m, 0x1p62 / m)));
    const auto begin_of = [&](std::int64_t row) { return row * count / rows; };
    for (std::int64_t row = 0; row < rows; ++row) {
      const std::int64_t row_begin = begin_of(row);
      const std::int64_t row_end = begin_of(row + 1);
      const double y =
          box.lower[1] + extent[1] * (0.5 * static_cast<double>(row_begin + row_end) / m);
      const double shift = rows == 1 ? 0.5 : row % 2 == 0 ? 0.25 : 0.75;
      const double spacing = extent[0] / static_cast<double>(row_end - row_begin);
      for (std::int64_t k = std::max(row_begin, begin); k < std::min(row_end, end); ++k) {
        Scalar* out = point(k);
        out[0] =
            bounds.round(0, box.lower[0] + (static_cast<double>(k - row_begin) + shift) * spacing);
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
    const std::int64_t first_chunk = begin / chunk_points;
    const std::int64_t chunks = (end - 1) / chunk_points + 1 - first_chunk;
    arena.for_each(static_cast<std::size_t>(chunks), 1, [&](std::size_t k) {
      const std::int64_t chunk = first_chunk + static_cast<std::int64_t>(k);
      Random random(seed, streams::uniform + static_cast<std::uint64_t>(chunk));
      const std::int64_t first = chunk * chunk_points;
      const std::int64_t last = std::min(first + chunk_points, end);
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

void check_sampling(const Box& box, std::int64_t count, int fixed_dimension,
                    std::size_t scalar_bytes) {
  if (count < 1) throw InvalidInput(concat("count: is ", count, ", but must be at least 1"));
  if (count > kMostPointsOfAll) {
    throw InvalidInput(concat("count: is ", count, ", but must be at most ", kMostPointsOfAll));
  }
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
  fill_uniform_part(box, std::ssize(coordinates) / box.dimension(), 0, seed, distribution, threads,
                    coordinates);
}

void fill_uniform(const Box& box, std::uint64_t seed, Distribution distribution, int threads,
                  std::span<double> coordinates) {
  fill_uniform_part(box, std::ssize(coordinates) / box.dimension(), 0, seed, distribution, threads,
                    coordinates);
}

void fill_uniform_part(const Box& box, std::int64_t count, std::int64_t first, std::uint64_t seed,
                       Distribution distribution, int threads, std::span<float> coordinates) {
  require_threads(threads);
  require_enumerator("distribution", distribution, Distribution::hexagonal);
  Fill<float>(box, count, first, coordinates).run(seed, distribution, threads);
}

void fill_uniform_part(const Box& box, std::int64_t count, std::int64_t first, std::uint64_t seed,
                       Distribution distribution, int threads, std::span<double> coordinates) {
  require_threads(threads);
  require_enumerator("distribution", distribution, Distribution::hexagonal);
  Fill<double>(box, count, first, coordinates).run(seed, distribution, threads);
}

}  // namespace detail
}  // namespace ccvt
