#include "ccvt/sampling.h"

#include <pybind11/stl.h>

#include <algorithm>
#include <span>
#include <string>

#include "arrays.h"
#include "bindings.h"
#include "ccvt/stipple.h"
#include "ccvt/surface.h"
#include "ccvt/thin.h"
#include "listener.h"
#include "lock.h"
#include "options.h"

namespace ccvt::python {

namespace {

Distribution distribution_from(const std::string& word) {
  if (word == "white") return Distribution::white;
  if (word == "jittered") return Distribution::jittered;
  if (word == "square") return Distribution::square;
  if (word == "hexagonal") return Distribution::hexagonal;
  throw InvalidInput("distribution: is '" + word +
                     "', but must be one of white, jittered, square, hexagonal");
}

/// As sample_uniform() does, but in parts, so that Python is heard between them.
template <class Scalar>
py::array uniform(const Box& box, Index count, std::uint64_t seed, Distribution distribution,
                  int threads) {
  constexpr Index at_once = 1 << 20;
  detail::check_sampling(box, count, Eigen::Dynamic, sizeof(Scalar));
  const py::ssize_t dimension = box.dimension();
  py::array_t<Scalar> points({static_cast<py::ssize_t>(count), dimension});
  const std::span<Scalar> coordinates(points.mutable_data(),
                                      static_cast<std::size_t>(points.size()));
  Listener listener((py::none()));
  listener.run([&, cancelled = listener.cancelled()] {
    for (std::int64_t first = 0; first < count; first += at_once) {
      if (cancelled()) throw Cancelled();
      const auto size = std::min<std::int64_t>(at_once, count - first) * dimension;
      detail::fill_uniform_part(box, count, first, seed, distribution, threads,
                                coordinates.subspan(static_cast<std::size_t>(first * dimension),
                                                    static_cast<std::size_t>(size)));
    }
    return true;
  });
  return points;
}

py::array sample_box(const py::array_t<double>& box, Index count, std::uint64_t seed,
                     const std::string& distribution, int threads, bool doubles) {
  const Box corners =
      domain_of(box, std::vector<bool>(static_cast<std::size_t>(box.shape(1)))).box();
  const Distribution kind = distribution_from(distribution);
  return doubles ? uniform<double>(corners, count, seed, kind, threads)
                 : uniform<float>(corners, count, seed, kind, threads);
}

Image image_of(const py::array_t<float>& values) {
  return {static_cast<int>(values.shape(1)), static_cast<int>(values.shape(0)), vector_of(values)};
}

template <class Scalar>
py::dict stipple_image(const Image& image, Index dots, StippleOptions options, Listener& listener) {
  listener.listen_to(options.tessellation);
  const auto made = listener.run([&] { return stipple<Scalar>(image, dots, options); });
  py::dict result;
  result["sites"] = array_of(made.dots);
  result["width"] = made.width;
  result["height"] = made.height;
  result["dot_radius"] = made.dot_radius;
  result["put_back"] = made.put_back;
  result["farthest_put_back"] = made.farthest_put_back;
  result["summary"] = dict_of(made.summary);
  return result;
}

py::dict run_stipple(const py::array_t<float>& image, Index dots, const py::dict& given,
                     const py::dict& options, const py::object& progress, bool doubles) {
  Listener listener(progress);
  StippleOptions made;
  made.points_per_site = given["points_per_site"].cast<Index>();
  made.invert = given["invert"].cast<bool>();
  made.gamma = given["gamma"].cast<double>();
  made.dot_radius = given["dot_radius"].cast<double>();
  made.tessellation = options_from(options, made.tessellation);
  return doubles ? stipple_image<double>(image_of(image), dots, made, listener)
                 : stipple_image<float>(image_of(image), dots, made, listener);
}

/// `dots` are float32 or float64 of shape (#dots, 2).
template <class Use>
auto with_stippling(const py::array& dots, int width, int height, double radius, const Use& use) {
  return visit_points(dots, [&]<class Scalar>(PointsView<Scalar>) {
    const Stippling<Scalar> stippling{width, height, columns_of<Scalar>(dots), radius, {}};
    return use(stippling);
  });
}

py::array render_dots(const py::array& dots, int width, int height, double radius, double scale) {
  return with_stippling(dots, width, height, radius, [&](const auto& stippling) -> py::array {
    const Image image = [&] {
      const Unlocked unlocked;
      return render(stippling, scale);
    }();
    return array_of(image.values.data(), {image.height, image.width});
  });
}

void write_dots(const std::string& path, const py::array& dots, int width, int height,
                double radius) {
  with_stippling(dots, width, height, radius, [&](const auto& stippling) {
    const Unlocked unlocked;
    write_svg(path, stippling);
  });
}

py::dict run_thin(const py::array& points, Index sites, const std::optional<py::array>& normals,
                  const py::dict& given, const py::dict& options, const py::object& progress) {
  Listener listener(progress);
  ThinOptions made;
  made.normal_weight = given["normal_weight"].cast<double>();
  made.spread = given["spread"].cast<bool>();
  made.equal_counts = given["equal_counts"].cast<bool>();
  made.tessellation = options_from(options, made.tessellation);
  listener.listen_to(made.tessellation);
  return visit_points(points, [&]<class Scalar>(PointsView<Scalar> view) {
    const PointsView<Scalar> directions =
        normals ? view_of<Scalar>(*normals) : PointsView<Scalar>();
    const Thinning found = listener.run([&] { return thin(view, sites, made, directions); });
    py::dict result;
    result["chosen"] = array_of(found.chosen);
    result["owners"] = array_of(found.owners);
    result["counts"] = array_of(found.counts);
    result["energy"] = found.energy;
    result["spacing"] = found.spacing;
    result["moves"] = found.moves;
    result["jumps"] = found.jumps;
    result["turned"] = found.turned;
    result["summary"] = dict_of(found.summary);
    return result;
  });
}

TriangleMesh mesh_of(const py::array& vertices, const py::array_t<Index>& triangles,
                     const std::optional<py::array_t<double>>& density) {
  TriangleMesh mesh;
  mesh.vertices = columns_of<double>(vertices);
  mesh.triangles = Columns<Index>(triangles.shape(1), triangles.shape(0));
  const auto corners = span_of(triangles);
  std::copy(corners.begin(), corners.end(), mesh.triangles.data());
  if (density) mesh.density = vector_of(*density);
  return mesh;
}

py::dict run_surface(const py::array& vertices, const py::array_t<Index>& triangles,
                     const std::optional<py::array_t<double>>& density, Index sites,
                     const py::dict& given, const py::dict& options, const py::object& progress,
                     bool doubles) {
  Listener listener(progress);
  const TriangleMesh mesh = mesh_of(vertices, triangles, density);
  SurfaceOptions made;
  made.points_per_site = given["points_per_site"].cast<Index>();
  made.normal_weight = given["normal_weight"].cast<double>();
  made.keep_points = given["keep_points"].cast<bool>();
  made.tessellation = options_from(options, made.tessellation);
  listener.listen_to(made.tessellation);
  const SurfaceSamples found = listener.run([&] {
    return doubles ? sample_surface<double>(mesh, sites, made)
                   : sample_surface<float>(mesh, sites, made);
  });
  py::dict result;
  result["sites"] = array_of(found.sites);
  result["normals"] = array_of(found.normals);
  result["triangles"] = array_of(found.triangles);
  result["barycentric"] = array_of(found.barycentric);
  result["capacities"] = array_of(found.capacities);
  result["weights"] = array_of(found.weights);
  result["radii"] = array_of(found.radii);
  result["area"] = found.area;
  result["points"] = array_of(found.points);
  result["owners"] = array_of(found.owners);
  result["summary"] = dict_of(found.summary);
  return result;
}

}  // namespace

void bind_sampling(py::module_& module) {
  module.def("sample_uniform", &sample_box);
  module.def("stipple", &run_stipple);
  module.def("render", &render_dots);
  module.def("write_svg", &write_dots);
  module.def("thin", &run_thin);
  module.def("sample_surface", &run_surface);
}

}  // namespace ccvt::python
