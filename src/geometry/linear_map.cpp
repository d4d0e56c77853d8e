#include "ccvt/linear_map.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "geometry/as_matrix.h"
#include "geometry/finite_points.h"
#include "number_text.h"

namespace ccvt {
namespace {

/// The relative error of mapping there and back: half of the digits of a double.
constexpr double kLargestError = 0x1p-26;

template <class Scalar>
void require_dimension(const PointsView<Scalar>& points, int dimension) {
  if (points.dimension == dimension) return;
  throw InvalidInput("points: have " + std::to_string(points.dimension) +
                     " dimensions, the map has " + std::to_string(dimension) +
                     ": the two must be equal");
}

/// The product of large numbers may be infinite, and be it by rounding to float.
template <class Scalar>
Columns<Scalar> finite(Columns<Scalar> points) {
  require_finite(points, "is mapped to");
  return points;
}

}  // namespace

LinearMap::LinearMap(Columns<double> matrix, Coordinates origin)
    : matrix_(std::move(matrix)), origin_(std::move(origin)) {
  const Eigen::MatrixXd inverse = matrix_.eigen().inverse();
  const auto size = inverse.rows();
  const double error =
      (matrix_.eigen() * inverse - Eigen::MatrixXd::Identity(size, size)).cwiseAbs().maxCoeff();
  if (!std::isfinite(error)) throw InvalidInput("matrix: is singular");
  if (!(error < kLargestError)) {
    throw InvalidInput("matrix: is so nearly singular that mapping there and back is off by " +
                       text(error) + " of the coordinates");
  }
  inverse_ = inverse;
}

LinearMap LinearMap::units(Coordinates factors) {
  if (factors.size() == 0) throw InvalidInput("units: there are none");
  for (std::ptrdiff_t d = 0; d < factors.size(); ++d) {
    if (factors[d] > 0 && std::isfinite(factors[d]) && std::isfinite(1 / factors[d])) continue;
    throw InvalidInput("units[" + std::to_string(d) + "] is " + text(factors[d]) +
                       ": it must be positive and finite, and its inverse too");
  }
  const Eigen::MatrixXd matrix = factors.eigen().asDiagonal();
  return {matrix, Coordinates::constant(factors.size(), 0)};
}

LinearMap LinearMap::of(Columns<double> matrix, Coordinates origin) {
  if (matrix.rows() == 0 || matrix.rows() != matrix.cols()) {
    throw InvalidInput("matrix: is " + std::to_string(matrix.rows()) + " by " +
                       std::to_string(matrix.cols()) + ": it must be square");
  }
  for (std::ptrdiff_t row = 0; row < matrix.rows(); ++row) {
    for (std::ptrdiff_t column = 0; column < matrix.cols(); ++column) {
      if (std::isfinite(matrix(row, column))) continue;
      throw InvalidInput("matrix(" + std::to_string(row) + ", " + std::to_string(column) + ") is " +
                         text(matrix(row, column)) + ": it must be finite");
    }
  }
  if (origin.size() == 0) origin = Coordinates::constant(matrix.rows(), 0);
  if (origin.size() != matrix.cols()) {
    throw InvalidInput("origin: has " + std::to_string(origin.size()) +
                       " coordinates, the matrix " + std::to_string(matrix.cols()) +
                       " columns: there must be one for each");
  }
  for (std::ptrdiff_t d = 0; d < origin.size(); ++d) {
    if (std::isfinite(origin[d])) continue;
    throw InvalidInput("origin[" + std::to_string(d) + "] is " + text(origin[d]) +
                       ": it must be finite");
  }
  return {std::move(matrix), std::move(origin)};
}

bool LinearMap::is_diagonal() const {
  const Eigen::MatrixXd diagonal = matrix_.eigen().diagonal().asDiagonal();
  return matrix_ == diagonal;
}

template <class Scalar>
Columns<Scalar> LinearMap::mapped(PointsView<Scalar> points) const {
  require_dimension(points, dimension());
  Columns<Scalar> result(points.dimension, points.count);
  const auto all = as_matrix(points);
  const Eigen::VectorXd factors = matrix_.eigen().diagonal();
  const bool diagonal = is_diagonal();
  const auto matrix = matrix_.eigen();
  const auto origin = origin_.eigen();
  auto out = result.eigen();
  for (Eigen::Index p = 0; p < all.cols(); ++p) {
    const Eigen::VectorXd from = all.col(p).template cast<double>() - origin;
    if (diagonal) {
      out.col(p) = from.cwiseProduct(factors).template cast<Scalar>();
    } else {
      out.col(p) = (matrix * from).template cast<Scalar>();
    }
  }
  return finite(std::move(result));
}

template <class Scalar>
Columns<Scalar> LinearMap::mapped_back(PointsView<Scalar> points) const {
  require_dimension(points, dimension());
  Columns<Scalar> result(points.dimension, points.count);
  const auto all = as_matrix(points);
  const auto inverse = inverse_.eigen();
  const auto origin = origin_.eigen();
  auto out = result.eigen();
  for (Eigen::Index p = 0; p < all.cols(); ++p) {
    out.col(p) = (inverse * all.col(p).template cast<double>() + origin).template cast<Scalar>();
  }
  return finite(std::move(result));
}

Domain LinearMap::operator()(const Domain& domain) const { return domain_of<double>(domain); }

template <class Scalar>
Domain LinearMap::domain_of(const Domain& domain) const {
  if (!domain.has_box()) return domain;
  const int dimensions = domain.box().dimension();
  if (dimensions != dimension()) {
    throw InvalidInput("domain: its box has " + std::to_string(dimensions) +
                       " dimensions, the map has " + std::to_string(dimension()) +
                       ": the two must be equal");
  }
  if (!is_diagonal()) {
    throw InvalidInput(
        "domain: has a box, and the map is no diagonal matrix: the image of a box "
        "under it is none");
  }
  Box box = domain.box();
  std::vector<bool> along;
  for (int d = 0; d < dimensions; ++d) {
    const double factor = matrix_(d, d);
    box.lower[d] = static_cast<Scalar>((box.lower[d] - origin_[d]) * factor);
    box.upper[d] = static_cast<Scalar>((box.upper[d] - origin_[d]) * factor);
    if (factor < 0) std::swap(box.lower[d], box.upper[d]);
    along.push_back(domain.is_periodic(d));
  }
  return Domain::periodic(std::move(box), along);
}

template CCVT_EXPORT Domain LinearMap::domain_of<float>(const Domain&) const;
template CCVT_EXPORT Domain LinearMap::domain_of<double>(const Domain&) const;
template CCVT_EXPORT Columns<float> LinearMap::mapped(PointsView<float>) const;
template CCVT_EXPORT Columns<double> LinearMap::mapped(PointsView<double>) const;
template CCVT_EXPORT Columns<float> LinearMap::mapped_back(PointsView<float>) const;
template CCVT_EXPORT Columns<double> LinearMap::mapped_back(PointsView<double>) const;

}  // namespace ccvt
