#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <initializer_list>
#include <utility>
#include <vector>

#include "ccvt/export.h"

/// Vectors and matrices that cross the border between the library and its users. Eigen's own may
/// not: how they are aligned depends on the flags of whoever compiles them. These keep their
/// numbers in a std::vector; what they do with Eigen is compiled by the user, with the user's
/// flags.
namespace ccvt {

/// One double for each dimension, such as the corner of a box: made from braces or from an Eigen
/// vector of any type of number, and looked at by Eigen through eigen().
class Coordinates {
 public:
  Coordinates() = default;
  Coordinates(std::initializer_list<double> values) : values_(values) {}
  explicit Coordinates(std::vector<double> values) : values_(std::move(values)) {}
  template <class Derived>
  Coordinates(const Eigen::MatrixBase<Derived>& values) {  // NOLINT: as an Eigen vector would
    static_assert(Derived::IsVectorAtCompileTime,
                  "ccvt: coordinates are a vector: one number for each dimension");
    resize(values.size());
    eigen() = values.derived().template cast<double>().reshaped();
  }
  static Coordinates constant(std::ptrdiff_t size, double value) {
    return Coordinates(std::vector<double>(static_cast<std::size_t>(size), value));
  }

  [[nodiscard]] std::ptrdiff_t size() const { return static_cast<std::ptrdiff_t>(values_.size()); }
  void resize(std::ptrdiff_t size) { values_.resize(static_cast<std::size_t>(size)); }
  [[nodiscard]] double operator[](std::ptrdiff_t d) const {
    return values_[static_cast<std::size_t>(d)];
  }
  [[nodiscard]] double& operator[](std::ptrdiff_t d) {
    return values_[static_cast<std::size_t>(d)];
  }
  [[nodiscard]] const double* data() const { return values_.data(); }
  [[nodiscard]] double* data() { return values_.data(); }
  [[nodiscard]] const double* begin() const { return data(); }
  [[nodiscard]] const double* end() const { return data() + size(); }

  /// A view, valid while this object lives and keeps its size; of a temporary, a copy.
  [[nodiscard]] Eigen::Map<const Eigen::VectorXd> eigen() const& { return {data(), count()}; }
  [[nodiscard]] Eigen::Map<Eigen::VectorXd> eigen() & { return {data(), count()}; }
  [[nodiscard]] Eigen::VectorXd eigen() const&& { return *this; }
  operator Eigen::VectorXd() const {  // NOLINT: a copy is harmless
    return Eigen::Map<const Eigen::VectorXd>(data(), count());
  }

  friend bool operator==(const Coordinates&, const Coordinates&) = default;

 private:
  /// Eigen's numbers may be of any type: EIGEN_DEFAULT_DENSE_INDEX_TYPE.
  [[nodiscard]] Eigen::Index count() const { return static_cast<Eigen::Index>(size()); }

  std::vector<double> values_;
};

/// A matrix stored column by column, such as #dimensions by #points: the memory of a NumPy array of
/// shape (#columns, #rows) in C order. Made from any Eigen matrix, and looked at by Eigen through
/// eigen() and col().
template <class Scalar>
class Columns {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  Columns() = default;
  /// Zeros.
  Columns(std::ptrdiff_t rows, std::ptrdiff_t cols)
      : rows_(rows), values_(static_cast<std::size_t>(rows * cols)) {}
  template <class Derived>
  Columns(const Eigen::DenseBase<Derived>& values)  // NOLINT: as an Eigen matrix would
      : Columns(values.rows(), values.cols()) {
    if (size() > 0) eigen().array() = values.derived().array().template cast<Scalar>();
  }

  [[nodiscard]] std::ptrdiff_t rows() const { return rows_; }
  [[nodiscard]] std::ptrdiff_t cols() const { return rows_ == 0 ? 0 : size() / rows_; }
  [[nodiscard]] std::ptrdiff_t size() const { return static_cast<std::ptrdiff_t>(values_.size()); }
  [[nodiscard]] Scalar operator()(std::ptrdiff_t row, std::ptrdiff_t column) const {
    return values_[static_cast<std::size_t>(row + column * rows_)];
  }
  [[nodiscard]] Scalar& operator()(std::ptrdiff_t row, std::ptrdiff_t column) {
    return values_[static_cast<std::size_t>(row + column * rows_)];
  }
  [[nodiscard]] const Scalar* data() const { return values_.data(); }
  [[nodiscard]] Scalar* data() { return values_.data(); }

  /// Views, valid while this object lives and keeps its size; of a temporary, copies.
  [[nodiscard]] Eigen::Map<const Matrix> eigen() const& { return {data(), height(), width()}; }
  [[nodiscard]] Eigen::Map<Matrix> eigen() & { return {data(), height(), width()}; }
  [[nodiscard]] Matrix eigen() const&& {
    return Eigen::Map<const Matrix>(data(), height(), width());
  }
  [[nodiscard]] Eigen::Map<const Column> col(std::ptrdiff_t column) const& {
    return {data() + column * rows_, height()};
  }
  [[nodiscard]] Column col(std::ptrdiff_t column) const&& {
    return Eigen::Map<const Column>(data() + column * rows_, height());
  }
  /// A copy: `Eigen::Matrix3Xf sites = samples.sites;`
  template <int Rows, int Cols>
  operator Eigen::Matrix<Scalar, Rows, Cols>() const {  // NOLINT: implicit, as Eigen's own are
    return eigen();
  }

  friend bool operator==(const Columns&, const Columns&) = default;
  template <class Derived>
  friend bool operator==(const Columns& a, const Eigen::DenseBase<Derived>& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() &&
           (a.eigen().array() == b.derived().array()).all();
  }

 private:
  // As Eigen counts.
  [[nodiscard]] Eigen::Index height() const { return static_cast<Eigen::Index>(rows_); }
  [[nodiscard]] Eigen::Index width() const { return static_cast<Eigen::Index>(cols()); }

  std::ptrdiff_t rows_ = 0;
  std::vector<Scalar> values_;
};

}  // namespace ccvt
