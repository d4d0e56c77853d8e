#include <pybind11/pybind11.h>

#include <cstring>

#include "arrays.h"
#include "bindings.h"
#include "ccvt/io.h"
#include "ccvt/version.h"

namespace ccvt::python {

Domain domain_of(const std::optional<py::array_t<double>>& box, const std::vector<bool>& along) {
  if (!box) return {};
  const auto size = box->shape(1);
  Box corners{Coordinates::constant(size, 0), Coordinates::constant(size, 0)};
  for (py::ssize_t d = 0; d < size; ++d) {
    corners.lower[d] = box->at(0, d);
    corners.upper[d] = box->at(1, d);
  }
  return Domain::periodic(std::move(corners), along);
}

}  // namespace ccvt::python

namespace {

/// Raises an exception with a message that may have file names of any bytes, as os.fsdecode() has
/// them.
void raise_as(PyObject* type, const char* message) {
  namespace py = pybind11;
  const auto text = py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
      message, static_cast<py::ssize_t>(std::strlen(message)), "surrogateescape"));
  if (text) PyErr_SetObject(type, text.ptr());
}

}  // namespace

PYBIND11_MODULE(_ccvt, module) {
  namespace py = pybind11;
  module.attr("__version__") = CCVT_VERSION;
  // NOLINTNEXTLINE(performance-unnecessary-value-param): pybind11 wants it by value
  py::register_exception_translator([](std::exception_ptr error) {
    try {
      if (error) std::rethrow_exception(error);
    } catch (const ccvt::IoError& caught) {
      raise_as(PyExc_OSError, caught.what());
    } catch (const ccvt::InvalidInput& caught) {
      raise_as(PyExc_ValueError, caught.what());
    } catch (const ccvt::Cancelled& caught) {
      PyErr_SetString(PyExc_RuntimeError, caught.what());
    }
  });
  ccvt::python::bind_solver(module);
  ccvt::python::bind_sampling(module);
  ccvt::python::bind_density(module);
  ccvt::python::bind_codebook(module);
  ccvt::python::bind_analysis(module);
  ccvt::python::bind_files(module);
}
