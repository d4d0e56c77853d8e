#pragma once

#include <pybind11/pybind11.h>

/// The parts of the module `ccvt._ccvt`. It is the Python side, src/python/ccvt, that checks and
/// converts arguments and documents them; here they are what the library takes.
namespace ccvt::python {

void bind_solver(pybind11::module_& module);
void bind_sampling(pybind11::module_& module);
void bind_density(pybind11::module_& module);
void bind_codebook(pybind11::module_& module);
void bind_analysis(pybind11::module_& module);
void bind_files(pybind11::module_& module);

}  // namespace ccvt::python
