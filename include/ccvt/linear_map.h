#pragma once

#include <Eigen/Core>

#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/ranks.h"
#include "ccvt/types.h"

namespace ccvt {

/// Another way to measure distances: |A (x - y)| for a regular matrix A, such as coordinates of
/// different units, spacing that is finer along one direction than along another, or Mahalanobis
/// distances. Centroids and capacities are the same in all linear coordinates, so points are
/// mapped, tessellated, and the sites mapped back:
///
///     const auto map = ccvt::LinearMap::units({1, 1, 0.2});  // five along z count as one
///     const Eigen::MatrixXd mapped = map(points);
///     const auto [sites, owners, summary] = ccvt::tessellate(mapped, 1000);
///     const Eigen::MatrixXd sites_as_given = map.inverse(sites);
///
/// Maps x to A (x - origin); computed in double, and rounded once. The energy of the summary is
/// that of the mapped points.
class CCVT_EXPORT LinearMap {
 public:
  /// Multiplies coordinate d by factors[d]; the origin stays. Throws InvalidInput unless there is a
  /// factor, and all are positive and finite, and their inverses too.
  static LinearMap units(Coordinates factors);
  /// x -> A (x - origin). Throws InvalidInput unless `matrix` is square, finite and far enough from
  /// singular that mapping there and back keeps half of the digits of double, and `origin`, finite,
  /// has a coordinate for each of its columns; by default 0.
  static LinearMap of(Columns<double> matrix, Coordinates origin = {});
  /// Distances in units of the points' own spread, |A (x - y)|^2 = (x - y)^T C^-1 (x - y) with C
  /// the covariance of `points` [Mahalanobis 1936]: A is the inverse of its lower Cholesky factor,
  /// and the origin their mean. O(m #dimensions^2). Throws InvalidInput where C is singular, or as
  /// nearly so as of() refuses: points that are fewer than the dimensions, or lie in a plane.
  template <class Derived>
  static LinearMap whitening(const Eigen::DenseBase<Derived>& points) {
    return whitening_of(view_points(points));
  }
  template <class Scalar>
  static LinearMap whitening(const Columns<Scalar>& points) {
    return whitening_of(view_points(points));
  }
  /// The same of the points of all ranks, each of which gives its own, to the bit, in the time of
  /// one: the sums go from rank to rank. All throw what one of them does.
  template <class Derived>
  static LinearMap whitening(Ranks& ranks, const Eigen::DenseBase<Derived>& own) {
    return whitening_of(ranks, view_points(own));
  }

  [[nodiscard]] int dimension() const { return static_cast<int>(matrix_.rows()); }
  [[nodiscard]] const Columns<double>& matrix() const { return matrix_; }
  [[nodiscard]] const Coordinates& origin() const { return origin_; }

  /// The points mapped, #dimensions by m. O(m #dimensions^2), O(m #dimensions) for units. Throws
  /// InvalidInput unless the points have as many dimensions, and stay finite.
  template <class Derived>
  Eigen::Matrix<typename Derived::Scalar, Derived::RowsAtCompileTime, Eigen::Dynamic> operator()(
      const Eigen::DenseBase<Derived>& points) const {
    return mapped(view_points(points));
  }
  template <class Scalar>
  Points<Scalar> operator()(const Columns<Scalar>& points) const {
    return (*this)(points.eigen());
  }
  /// Mapped back.
  template <class Derived>
  Eigen::Matrix<typename Derived::Scalar, Derived::RowsAtCompileTime, Eigen::Dynamic> inverse(
      const Eigen::DenseBase<Derived>& points) const {
    return mapped_back(view_points(points));
  }
  template <class Scalar>
  Points<Scalar> inverse(const Columns<Scalar>& points) const {
    return inverse(points.eigen());
  }
  /// The box mapped, with the dimensions that are periodic. Throws InvalidInput unless the matrix
  /// is diagonal: else the image of a box is none.
  [[nodiscard]] Domain operator()(const Domain& domain) const;
  /// The same for points of Scalar, float or double: its corners are rounded as their coordinates
  /// are, so that points on the faces of a box have images in it.
  template <class Scalar>
  [[nodiscard]] Domain domain_of(const Domain& domain) const;

 private:
  LinearMap(Columns<double> matrix, Coordinates origin);
  [[nodiscard]] bool is_diagonal() const;
  template <class Scalar>
  [[nodiscard]] Columns<Scalar> mapped(PointsView<Scalar> points) const;
  template <class Scalar>
  [[nodiscard]] Columns<Scalar> mapped_back(PointsView<Scalar> points) const;
  template <class Scalar>
  static LinearMap whitening_of(PointsView<Scalar> points);
  template <class Scalar>
  static LinearMap whitening_of(Ranks& ranks, PointsView<Scalar> own);

  Columns<double> matrix_;
  Columns<double> inverse_;
  Coordinates origin_;
};

}  // namespace ccvt
