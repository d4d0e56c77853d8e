#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "parallel/arena.h"
#include "random.h"
#include "streams.h"
#include "surface/triangles.h"

namespace ccvt {

/// The triangles that points may fall on, one behind the other: those of a group of sheets in a
/// row, and in it along a Hilbert curve.
struct TriangleLine {
  std::vector<Index> triangle;
  std::vector<Index> group;
  std::vector<double> end;  ///< the mass up to the end of each
  [[nodiscard]] double mass() const { return end.back(); }
};

/// `masses`: of each triangle, some positive, of finite sum; those without are left out. Sheets
/// that have `least_mass` are groups of their own, the others together are one, the last.
TriangleLine line_up(const Triangles& triangles, const Sheets& sheets,
                     const std::vector<double>& masses, double least_mass);

/// A point on a triangle.
struct SurfacePoint {
  Index group = 0;
  Index triangle = 0;
  Eigen::Vector3d shares;  ///< barycentric coordinates
};

/// `count` points by mass, one of each of as many equal parts of the line. O(log F) each.
class SurfaceDraws {
 public:
  SurfaceDraws(const Triangles& triangles, const TriangleLine& line, Index count,
               std::uint64_t seed)
      : triangles_(triangles), line_(line), count_(count), seed_(seed) {}

  /// Calls visit(number, point) for all, from several threads.
  template <class Visit>
  void visit(const Arena& arena, const Visit& visit) const {
    arena.for_ranges(static_cast<std::size_t>(count_), kPointsPerGrain,
                     [&](std::size_t begin, std::size_t end, int) {
                       Random random(seed_, streams::surface + begin / kPointsPerGrain);
                       for (std::size_t k = begin; k < end; ++k) visit(k, draw(k, random));
                     });
  }

 private:
  static constexpr std::size_t kPointsPerGrain = 4096;

  [[nodiscard]] SurfacePoint draw(std::size_t number, Random& random) const;

  const Triangles& triangles_;
  const TriangleLine& line_;
  Index count_;
  std::uint64_t seed_;
};

}  // namespace ccvt
