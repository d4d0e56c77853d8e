#pragma once

#include <cmath>
#include <vector>

#include "ccvt/metrics.h"
#include "ccvt/sampling.h"
#include "random.h"

/// Point sets on the torus whose figures are known.
namespace ccvt::test {

/// `cells` by `cells` by ... copies of a cubic cell of side `side` with the given points in it.
inline PointSet crystal(const Points<double>& basis, double side, int cells) {
  const auto dimension = static_cast<int>(basis.rows());
  Eigen::Index copies = 1;
  for (int d = 0; d < dimension; ++d) copies *= cells;
  Points<double> points(dimension, copies * basis.cols());
  for (Eigen::Index c = 0; c < copies; ++c) {
    Eigen::VectorXd corner(dimension);
    Eigen::Index rest = c;
    for (int d = 0; d < dimension; ++d, rest /= cells) {
      corner[d] = side * static_cast<double>(rest % cells);
    }
    points.middleCols(c * basis.cols(), basis.cols()) = basis.colwise() + corner;
  }
  const Eigen::VectorXd upper = Eigen::VectorXd::Constant(dimension, side * cells);
  return PointSet(points, Domain::periodic({Eigen::VectorXd::Zero(dimension), upper}));
}

inline PointSet cubic(int dimension, int cells) {
  return crystal(Points<double>::Zero(dimension, 1), 1, cells);
}

/// D_n: whole numbers with an even sum.
inline PointSet checkerboard(int dimension, int cells) {
  std::vector<double> values;
  for (unsigned bits = 0; bits < 1U << static_cast<unsigned>(dimension); ++bits) {
    if (__builtin_popcount(bits) % 2 != 0) continue;
    for (int d = 0; d < dimension; ++d) {
      values.push_back(static_cast<double>(bits >> static_cast<unsigned>(d) & 1U));
    }
  }
  return crystal(Eigen::Map<Points<double>>(values.data(), dimension,
                                            static_cast<Eigen::Index>(values.size()) / dimension),
                 2, cells);
}

/// E8: D8 and D8 shifted by (1/2, ..., 1/2), one cell of side 2.
inline PointSet e8() {
  const Points<double> even = checkerboard(8, 1).points();
  Points<double> basis(8, 2 * even.cols());
  basis << even, (even.array() + 0.5).matrix();
  return crystal(basis, 2, 1);
}

/// 2 * columns * rows points with spacing 1.
inline PointSet hexagonal(int columns, int rows) {
  Points<double> points(2, 2 * columns * rows);
  const double height = std::sqrt(3.0);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const Eigen::Index p = 2 * (r * columns + c);
      points.col(p) << c, r * height;
      points.col(p + 1) << c + 0.5, (r + 0.5) * height;
    }
  }
  return PointSet(
      points, Domain::periodic({Eigen::Vector2d(0, 0), Eigen::Vector2d(columns, rows * height)}));
}

inline PointSet white(int dimension, Index count, std::uint64_t seed) {
  const Box box = Box::unit(dimension);
  return PointSet(sample_uniform<double>(box, count, seed, Distribution::white),
                  Domain::periodic(box));
}

/// Poisson-disk points by dart throwing, on the unit torus.
inline PointSet darts(int dimension, Index count, double radius, std::uint64_t seed) {
  Random random(seed);
  Points<double> points(dimension, count);
  for (Eigen::Index p = 0; p < count;) {
    for (int d = 0; d < dimension; ++d) points(d, p) = random.uniform();
    bool free = true;
    for (Eigen::Index q = 0; q < p && free; ++q) {
      Eigen::ArrayXd difference = points.col(p) - points.col(q);
      difference -= difference.round();
      free = difference.square().sum() >= radius * radius;
    }
    if (free) ++p;
  }
  return PointSet(points, Domain::periodic(Box::unit(dimension)));
}

}  // namespace ccvt::test
