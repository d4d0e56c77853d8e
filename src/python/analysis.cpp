#include <pybind11/stl.h>

#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "ccvt/metrics.h"
#include "listener.h"
#include "lock.h"

namespace ccvt::python {

namespace {

/// One figure of each item.
template <class Item, class Figure>
py::array_t<double> figures(const std::vector<Item>& items, const Figure& figure) {
  std::vector<double> values;
  values.reserve(items.size());
  for (const Item& item : items) values.push_back(figure(item));
  return array_of(values);
}

py::dict dict_of(const Spectrum& spectrum) {
  py::dict result;
  const auto& rings = spectrum.rings;
  result["frequency"] = figures(rings, [](const auto& ring) { return ring.middle(); });
  result["lower"] = figures(rings, [](const auto& ring) { return ring.lower; });
  result["upper"] = figures(rings, [](const auto& ring) { return ring.upper; });
  result["frequencies"] = figures(rings, [](const auto& ring) { return ring.frequencies; });
  result["power"] = figures(rings, [](const auto& ring) { return ring.power; });
  result["anisotropy_db"] = figures(rings, [](const auto& ring) { return ring.anisotropy_db; });
  std::vector<py::ssize_t> shape;  // the last axis of the array is the library's first dimension
  for (const int half : spectrum.half) shape.insert(shape.begin(), 2 * half + 1);
  result["periodogram"] = spectrum.power.empty()
                              ? py::object(py::none())
                              : py::object(array_of(spectrum.power.data(), shape));
  result["low_frequency_power"] = spectrum.low_frequency_power;
  result["low_frequency_slope"] = spectrum.low_frequency_slope;
  result["low_frequency_slope_error"] = spectrum.low_frequency_slope_error;
  result["peak"] = spectrum.peak;
  result["peak_frequency"] = spectrum.peak_frequency;
  result["effective_nyquist"] = spectrum.effective_nyquist;
  result["oscillation"] = spectrum.oscillation;
  return result;
}

py::dict run_analyze(const std::vector<py::array>& sets, const py::array_t<double>& box,
                     const std::vector<bool>& along, double max_frequency, std::uint64_t seed,
                     int threads) {
  const Domain domain = domain_of(box, along);
  Listener listener((py::none()));
  std::vector<PointSet> checked;
  for (const py::array& set : sets) {
    visit_points(set, [&]<class Scalar>(PointsView<Scalar>) {
      checked.emplace_back(detail::on_faces<Scalar>(columns_of<double>(set), domain.box()), domain);
    });
  }
  SpectrumOptions options;
  options.max_frequency = max_frequency;
  options.seed = seed;
  options.threads = threads;
  options.cancelled = listener.cancelled();
  const Analysis found = listener.run([&] { return analyze(checked, options); });
  py::dict result;
  result["dimension"] = found.dimension;
  result["points"] = found.points;
  result["sets"] = found.sets;
  result["smallest_distance"] = found.distances.smallest;
  result["mean_distance"] = found.distances.mean;
  result["spectrum"] = dict_of(found.spectrum);
  result["pair_bin_width"] = found.pairs.bin_width;
  result["pair_correlation"] = array_of(found.pairs.value);
  result["psi6_local"] = found.order.psi6_local;
  result["psi6_global"] = found.order.psi6_global;
  result["six_sided"] = found.order.six_sided;
  result["star_discrepancy"] = found.star_discrepancy;
  result["integration_gaussian"] = found.integration.gaussian;
  result["integration_disk"] = found.integration.disk;
  result["integration_step"] = found.integration.step;
  return result;
}

double energy_of(const py::array& points, const py::array& sites, const py::array_t<Index>& owners,
                 const std::optional<py::array_t<double>>& box, const std::vector<bool>& along) {
  const Domain domain = domain_of(box, along);
  return visit_points(points, [&]<class Scalar>(PointsView<Scalar> view) {
    const PointsView<Scalar> places = view_of<Scalar>(sites);
    const std::span<const Index> of_points = span_of(owners);
    const Unlocked unlocked;
    return energy(view, places, of_points, domain);
  });
}

}  // namespace

void bind_analysis(py::module_& module) {
  module.def("analyze", &run_analyze);
  module.def("energy", &energy_of);
}

}  // namespace ccvt::python
