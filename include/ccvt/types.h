#pragma once

#if __cplusplus < 202002L
#error "ccvt needs C++20: compile with -std=c++20"
#endif

#include <Eigen/Core>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <type_traits>

#include "ccvt/columns.h"

namespace ccvt {

/// Number of a point or a site, and the unit of capacities. One process has fewer than 2^31 points;
/// several may have more together: see Problem.
using Index = std::int32_t;

/// A point set with dimension known at run time: #dimensions by #points, one point a column.
/// The memory layout is that of a NumPy array of shape (#points, #dimensions) in C order.
template <class Scalar>
using Points = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

/// Thrown for every mistake in what the caller hands in. The message names the argument, the
/// offending value and its index, and the rule it breaks.
class InvalidInput : public std::invalid_argument {
 public:
  explicit InvalidInput(const std::string& message) : std::invalid_argument(message) {}
};

/// Thrown by functions that have nothing to give when a callback of the caller's cancels them.
class Cancelled : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override { return "cancelled by the caller"; }
};

/// A read-only view of a point set owned by somebody else: column p is at data + p * stride.
/// The coordinates of a point are contiguous; `stride` >= `dimension`.
template <class Scalar>
struct PointsView {
  const Scalar* data = nullptr;
  int dimension = 0;
  Index count = 0;
  std::ptrdiff_t stride = 0;

  [[nodiscard]] const Scalar* operator[](Index point) const { return data + point * stride; }
};

/// Views any Eigen matrix of float or double that stores its points as columns, without a copy.
/// RowMajor matrices and unevaluated expressions are refused at compile time: they would have to
/// be copied. Throws InvalidInput when there are 2^31 points or more.
template <class Derived>
PointsView<typename Derived::Scalar> view_points(const Eigen::DenseBase<Derived>& points) {
  using Scalar = typename Derived::Scalar;
  static_assert(std::is_same_v<Scalar, float> || std::is_same_v<Scalar, double>,
                "ccvt: coordinates must be float or double: convert integers and other numbers by "
                "points.cast<float>().eval() first");
  static_assert((Derived::Flags & Eigen::DirectAccessBit) != 0,
                "ccvt: evaluate the expression into a matrix first: points are used in place");
  static_assert(!Derived::IsRowMajor || Derived::RowsAtCompileTime == 1,
                "ccvt: points are columns: pass a column-major #dimensions x #points matrix");
  static_assert(Derived::InnerStrideAtCompileTime == 1 || Derived::RowsAtCompileTime == 1 ||
                    Derived::InnerStrideAtCompileTime == Eigen::Dynamic,
                "ccvt: the coordinates of a point must be contiguous");
  if (points.rows() > 1 && points.derived().innerStride() != 1) {
    throw InvalidInput("points: the inner stride is " +
                       std::to_string(points.derived().innerStride()) +
                       ": the coordinates of a point must be contiguous");
  }
  if (points.cols() > INT32_MAX) {
    throw InvalidInput("points: there are " + std::to_string(points.cols()) +
                       " of them, but at most 2147483647 are supported");
  }
  const auto& p = points.derived();
  const bool one_row = Derived::RowsAtCompileTime == 1 && Derived::IsRowMajor;
  return {p.data(), static_cast<int>(p.rows()), static_cast<Index>(p.cols()),
          one_row ? p.innerStride() : p.outerStride()};
}
template <class Scalar>
PointsView<Scalar> view_points(const Columns<Scalar>& points) {
  return view_points(points.eigen());
}

}  // namespace ccvt
