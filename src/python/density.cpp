#include "ccvt/density.h"

#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <type_traits>

#include "arrays.h"
#include "bindings.h"
#include "ccvt/volume.h"
#include "listener.h"
#include "options.h"

namespace ccvt::python {

namespace {

/// The values of a contiguous array of any type that the library takes, where they are.
template <class... Values>
GridValues values_of(const py::array& values, std::variant<std::span<const Values>...>*) {
  GridValues result;
  const bool known =
      ((py::isinstance<py::array_t<Values>>(values)
            ? (result = std::span<const Values>(static_cast<const Values*>(values.data()),
                                                static_cast<std::size_t>(values.size())),
               true)
            : false) ||
       ...);
  if (!known) throw std::logic_error("ccvt: values of a type that the library lacks");
  return result;
}

ValueMap map_from(const py::dict& given) {
  ValueMap map;
  const auto kind = given["map"].cast<std::string>();
  map.low = given["low"].cast<double>();
  map.high = given["high"].cast<double>();
  map.gamma = given["gamma"].cast<double>();
  map.invert = given["invert"].cast<bool>();
  map.kind = kind == "window"      ? ValueMap::Kind::window
             : kind == "threshold" ? ValueMap::Kind::threshold
             : kind == "gamma"     ? ValueMap::Kind::gamma
                                   : ValueMap::Kind::linear;
  map.validate();
  return map;
}

/// The density as `given` describes it: a view of arrays that `given` holds.
DensityGrid density_of(const py::dict& given) {
  const auto values = given["values"].cast<py::array>();
  Grid grid;
  grid.shape = given["shape"].cast<std::vector<std::int64_t>>();
  grid.origin = coordinates_of(given["origin"].cast<py::array_t<double>>());
  grid.axes = columns_of<double>(given["axes"].cast<py::array>());
  DensityGrid density = grid.density(
      values_of(values, static_cast<detail::SpanOfNumbers*>(nullptr)),
      given["interpolation"].cast<std::string>() == "constant" ? Interpolation::constant
                                                               : Interpolation::linear);
  const ValueMap map = map_from(given);
  if (map.kind != ValueMap::Kind::linear || map.invert) {
    density.map = [map, greatest = given["greatest"].cast<double>()](double value) {
      return map(value, greatest);
    };
  }
  if (given.contains("mask")) {
    const auto mask = given["mask"].cast<py::array_t<std::uint8_t>>();
    density.mask = span_of(mask);
  }
  return density;
}

py::dict run_volume(const py::dict& given, Index sites, const py::dict& options,
                    const py::object& progress, bool doubles) {
  Listener listener(progress);
  const DensityGrid density = density_of(given);
  VolumeOptions made;
  made.points_per_site = given["points_per_site"].cast<Index>();
  made.keep_points = given["keep_points"].cast<bool>();
  made.tessellation = options_from(options, made.tessellation);
  listener.listen_to(made.tessellation);
  const VolumeSamples found = listener.run([&] {
    return doubles ? sample_volume<double>(density, sites, made)
                   : sample_volume<float>(density, sites, made);
  });
  py::dict result;
  result["sites"] = array_of(found.sites);
  result["capacities"] = array_of(found.capacities);
  result["weights"] = array_of(found.weights);
  result["radii"] = array_of(found.radii);
  result["put_back"] = found.put_back;
  result["farthest_put_back"] = found.farthest_put_back;
  result["points"] = array_of(found.points);
  result["owners"] = array_of(found.owners);
  result["summary"] = dict_of(found.summary);
  return result;
}

}  // namespace

void bind_density(py::module_& module) { module.def("sample_volume", &run_volume); }

}  // namespace ccvt::python
