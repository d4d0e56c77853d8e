#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/types.h"

/// NumPy arrays as the library's views, and back. The Python side of the module has checked types,
/// shapes and strides: what is wrong here is a mistake of ours.
namespace ccvt::python {

namespace py = pybind11;

/// The points of an array of shape (N, D), where they are: rows without gaps, rows apart or not.
template <class Scalar>
PointsView<Scalar> view_of(const py::array& points) {
  const auto item = static_cast<py::ssize_t>(sizeof(Scalar));
  // Strides that lead nowhere may be anything.
  const bool columns = points.ndim() == 2 && points.size() > 0 && points.shape(1) > 1;
  const bool rows = points.ndim() == 2 && points.size() > 0 && points.shape(0) > 1;
  if (points.ndim() != 2 || !py::isinstance<py::array_t<Scalar>>(points) ||
      (columns && points.strides(1) != item) || (rows && points.strides(0) % item != 0)) {
    throw std::logic_error("ccvt: an array that is no points got past the checks");
  }
  if (points.shape(0) > INT32_MAX) {
    throw InvalidInput("points: there are " + std::to_string(points.shape(0)) +
                       " of them, but at most 2147483647 are supported");
  }
  if (points.shape(1) > INT32_MAX) {
    throw InvalidInput("points: have " + std::to_string(points.shape(1)) +
                       " dimensions, but at most 2147483647 are supported");
  }
  return {static_cast<const Scalar*>(points.data()), static_cast<int>(points.shape(1)),
          static_cast<Index>(points.shape(0)), rows ? points.strides(0) / item : points.shape(1)};
}

/// visit(view) with points of float or of double, as the array has them.
template <class Visit>
auto visit_points(const py::array& points, const Visit& visit) {
  if (py::isinstance<py::array_t<float>>(points)) return visit(view_of<float>(points));
  return visit(view_of<double>(points));
}

/// #dimensions by #points: a copy, converted.
template <class Scalar>
Columns<Scalar> columns_of(const py::array& points) {
  return visit_points(points, [](auto view) {
    Columns<Scalar> result(view.dimension, view.count);
    for (Index p = 0; p < view.count; ++p) {
      for (int d = 0; d < view.dimension; ++d) result(d, p) = static_cast<Scalar>(view[p][d]);
    }
    return result;
  });
}

/// The numbers of a contiguous array, in C or Fortran order, where they are.
template <class Value>
std::span<const Value> span_of(const py::array_t<Value>& values) {
  if ((values.flags() & (py::array::c_style | py::array::f_style)) == 0) {
    throw std::logic_error("ccvt: an array that is not contiguous got past the checks");
  }
  return {values.data(), static_cast<std::size_t>(values.size())};
}

template <class Value>
std::vector<Value> vector_of(const py::array_t<Value>& values) {
  const auto span = span_of(values);
  return {span.begin(), span.end()};
}

/// An array that owns its memory.
template <class Value>
py::array_t<Value> array_of(const Value* values, std::vector<py::ssize_t> shape) {
  py::array_t<Value> result(std::move(shape));
  if (result.size() > 0) {
    std::memcpy(result.mutable_data(), values,
                sizeof(Value) * static_cast<std::size_t>(result.size()));
  }
  return result;
}
template <class Value>
py::array_t<Value> array_of(const std::vector<Value>& values) {
  return array_of(values.data(), {static_cast<py::ssize_t>(values.size())});
}
/// Of shape (#columns, #rows).
template <class Value>
py::array_t<Value> array_of(const Columns<Value>& values) {
  return array_of(values.data(), {values.cols(), values.rows()});
}
template <class Value>
py::array_t<Value> array_of(const Points<Value>& values) {
  return array_of(values.data(), {values.cols(), values.rows()});
}

inline Coordinates coordinates_of(const py::array_t<double>& values) {
  return Coordinates(vector_of(values));
}

/// `box`: None, or both corners, of shape (2, D); `along`: of each dimension whether it is
/// periodic.
Domain domain_of(const std::optional<py::array_t<double>>& box, const std::vector<bool>& along);

}  // namespace ccvt::python
