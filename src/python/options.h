#pragma once

#include <pybind11/pybind11.h>

#include "ccvt/codebook.h"
#include "ccvt/options.h"
#include "ccvt/summary.h"

namespace ccvt::python {

namespace py = pybind11;

/// The options that `given` names take the place of those in `defaults`; `preset` first. Of the
/// keys that the Python side writes none is unknown.
Options options_from(const py::dict& given, Options defaults);
CodebookOptions codebook_options_from(const py::dict& given);

/// The fields of the classes in _records.py, by name.
py::dict dict_of(const Summary& summary);
py::dict dict_of(const CodebookSummary& summary);

}  // namespace ccvt::python
