#include <pybind11/stl.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "arrays.h"
#include "bindings.h"
#include "ccvt/io.h"
#include "ccvt/particles.h"
#include "ccvt/surface.h"
#include "ccvt/volume.h"
#include "lock.h"

namespace ccvt::python {

namespace {

using Path = std::string;

template <class Scalar>
py::array read_as(const Path& path, const ReadOptions& options) {
  const auto points = [&] {
    const Unlocked unlocked;
    return ccvt::read_points<Scalar>(path, options);
  }();
  return array_of(points);
}

/// `type`: float32, float64 or "", which is as the file has them.
py::array read_points_file(const Path& path, const std::vector<std::string>& columns,
                           const std::string& type) {
  const ReadOptions options{columns};
  const bool floats = type.empty() ? inspect_points(path, options).scalar == ScalarType::float32
                                   : type == "float32";
  return floats ? read_as<float>(path, options) : read_as<double>(path, options);
}

void write_points_file(const Path& path, const py::array& points) {
  visit_points(points, [&](auto view) {
    const Unlocked unlocked;
    write_points(path, view);
  });
}

void write_particle_file(const Path& path, const py::array& sites, const py::dict& given) {
  ParticleOptions options;
  options.box_size = given["box_size"].cast<double>();
  options.repeat = given["repeat"].cast<int>();
  options.density = given["density"].cast<double>();
  options.redshift = given["redshift"].cast<double>();
  options.gadget_format = given["gadget_format"].cast<int>();
  options.type = given["gas"].cast<bool>() ? ParticleType::gas : ParticleType::dark_matter;
  visit_points(sites, [&](auto view) {
    const Unlocked unlocked;
    write_particles(path, view, options);
  });
}

py::array read_grey(const Path& path) {
  const Image image = read_image(path);
  return array_of(image.values.data(), {image.height, image.width});
}

void write_grey(const Path& path, const py::array_t<float>& values) {
  write_png(path, Image{static_cast<int>(values.shape(1)), static_cast<int>(values.shape(0)),
                        vector_of(values)});
}

void write_colour(const Path& path, const py::array_t<std::uint8_t>& values) {
  write_png(path, ColourImage{static_cast<int>(values.shape(1)), static_cast<int>(values.shape(0)),
                              vector_of(values)});
}

py::dict read_volume_file(const Path& path) {
  const Volume volume = [&] {
    const Unlocked unlocked;
    return read_volume(path);
  }();
  py::dict result;
  std::visit(
      [&](const auto& numbers) {
        result["values"] = array_of(numbers.data(), {static_cast<py::ssize_t>(numbers.size())});
      },
      volume.stored());
  result["shape"] = volume.grid.shape;
  result["origin"] = array_of(volume.grid.origin.data(), {volume.grid.origin.size()});
  result["axes"] = array_of(volume.grid.axes);
  result["slope"] = volume.slope;
  result["intercept"] = volume.intercept;
  return result;
}

py::tuple read_mesh_file(const Path& path, const std::string& density) {
  const TriangleMesh mesh = [&] {
    const Unlocked unlocked;
    return read_mesh(path, density);
  }();
  return py::make_tuple(
      array_of(mesh.vertices), array_of(mesh.triangles),
      mesh.density.empty() ? py::object(py::none()) : py::object(array_of(mesh.density)));
}

/// What samples of volumes and of surfaces have in common, and files hold.
template <class Samples>
Samples samples_from(const py::dict& given) {
  Samples samples;
  samples.sites = columns_of<double>(given["sites"].cast<py::array>());
  samples.capacities = vector_of(given["capacities"].cast<py::array_t<Index>>());
  samples.weights = vector_of(given["weights"].cast<py::array_t<double>>());
  samples.radii = vector_of(given["radii"].cast<py::array_t<double>>());
  samples.scalar = given["doubles"].cast<bool>() ? ScalarType::float64 : ScalarType::float32;
  return samples;
}

void write_samples_file(const Path& path, const py::dict& given) {
  if (!given.contains("triangles")) {
    write_samples(path, samples_from<VolumeSamples>(given));
    return;
  }
  auto samples = samples_from<SurfaceSamples>(given);
  samples.triangles = vector_of(given["triangles"].cast<py::array_t<Index>>());
  samples.barycentric = columns_of<double>(given["barycentric"].cast<py::array>());
  samples.normals = columns_of<double>(given["normals"].cast<py::array>());
  write_samples(path, samples);
}

void write_owner_file(const Path& path, const py::array_t<Index>& owners) {
  write_owners(path, span_of(owners));
}

}  // namespace

void bind_files(py::module_& module) {
  module.def("read_points", &read_points_file);
  module.def("write_points", &write_points_file);
  module.def("write_particles", &write_particle_file);
  module.def("read_indices", [](const Path& path) { return array_of(read_indices(path)); });
  module.def("read_numbers", [](const Path& path) { return array_of(read_numbers(path)); });
  module.def("write_owners", &write_owner_file);
  module.def("read_image", &read_grey);
  module.def("write_grey", &write_grey);
  module.def("write_colour", &write_colour);
  module.def("read_volume", &read_volume_file);
  module.def("read_mesh", &read_mesh_file);
  module.def("write_samples", &write_samples_file);
}

}  // namespace ccvt::python
