#include "ccvt/codebook.h"

#include <pybind11/stl.h>

#include <optional>
#include <string>

#include "arrays.h"
#include "bindings.h"
#include "listener.h"
#include "options.h"

namespace ccvt::python {

namespace {

py::dict train(const py::array& vectors, Index codewords, const std::optional<py::array>& initial,
               const py::dict& options, const py::object& progress) {
  Listener listener(progress);
  CodebookOptions made = codebook_options_from(options);
  listener.listen_to(made);
  const auto start = initial ? std::optional(columns_of<double>(*initial)) : std::nullopt;
  const Training found = visit_points(vectors, [&](auto view) {
    return listener.run([&] {
      return start ? train_codebook_from(view, *start, made)
                   : train_codebook(view, codewords, made);
    });
  });
  py::dict result;
  result["codewords"] = array_of(Columns<double>(found.codebook.codewords()));
  result["weights"] = array_of(found.codebook.weights().data(), {found.codebook.size()});
  result["codes"] = array_of(found.codes);
  result["summary"] = dict_of(found.summary);
  return result;
}

py::array encode(const py::array& vectors, const py::array& codewords,
                 const py::array_t<double>& weights, bool weighted, int threads) {
  Listener listener((py::none()));
  const Codebook codebook(columns_of<double>(codewords), coordinates_of(weights));
  const auto codes = visit_points(vectors, [&](auto view) {
    return listener.run([&] {
      return codebook.encode(view, weighted ? Coding::weighted : Coding::nearest, threads,
                             listener.cancelled());
    });
  });
  return array_of(codes);
}

}  // namespace

void bind_codebook(py::module_& module) {
  module.def("train_codebook", &train);
  module.def("encode", &encode);
}

}  // namespace ccvt::python
