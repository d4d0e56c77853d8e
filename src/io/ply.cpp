#include "io/ply.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "io/columns.h"
#include "io/ply_file.h"
#include "io/points_map.h"
#include "io/text.h"

namespace ccvt::io {

PlyElement& find_ply_vertices(PlyFile& ply, const ReadOptions& options) {
  PlyElement* const vertices = ply.find("vertex");
  if (vertices == nullptr) ply.file().fail("has no element 'vertex'");
  std::vector<std::string> names;
  std::vector<PlyProperty*> properties;
  for (PlyProperty& property : vertices->properties) {
    if (property.list) continue;
    names.push_back(property.name);
    properties.push_back(&property);
  }
  std::vector<std::string> wanted = options.columns;
  if (wanted.empty()) {
    std::array<std::ptrdiff_t, 3> given{};
    for (std::size_t d = 0; d < 3; ++d) {
      given[d] = std::count(names.begin(), names.end(), std::string(1, "xyz"[d]));
    }
    if (given[0] != 1 || given[1] != 1 || given[2] > 1) {
      ply.file().fail("vertices need one x and one y, and at most one z");
    }
    wanted = {"x", "y", "z"};
    wanted.resize(given[2] == 1 ? 3 : 2);
  }
  const TableColumns columns = choose_columns(ply.file(), wanted, names, names.size());
  int axis = 0;
  for (const std::size_t at : columns.at) properties[at]->slot = axis++;
  ply.check_count(*vertices);
  return *vertices;
}

PointsHeader ply_header(const PlyElement& vertices) {
  PointsHeader header;
  header.scalar = ScalarType::float32;
  for (const PlyProperty& property : vertices.properties) {
    if (property.slot < 0) continue;
    ++header.dimension;
    if (property.type != PlyType::float32) header.scalar = ScalarType::float64;
  }
  header.columns.resize(static_cast<std::size_t>(header.dimension));
  for (const PlyProperty& property : vertices.properties) {
    if (property.slot >= 0) header.columns[static_cast<std::size_t>(property.slot)] = property.name;
  }
  header.count = vertices.count;
  return header;
}

void fail_ply_coordinate(PlyFile& ply, const PlyElement& vertices, std::int64_t vertex, int axis,
                         double value) {
  const auto property =
      std::find_if(vertices.properties.begin(), vertices.properties.end(),
                   [axis](const PlyProperty& candidate) { return candidate.slot == axis; });
  std::string text;
  append(text, value);
  ply.file().fail(
      "vertex " + std::to_string(vertex) + ": " + property->name + " is " + text +
      (std::isfinite(value) ? ", out of the range of float32" : "; coordinates must be finite"));
}

PointsHeader inspect_ply_points(const std::filesystem::path& path, const ReadOptions& options) {
  PlyFile ply(path);
  return ply_header(find_ply_vertices(ply, options));
}

template <class Scalar>
void read_ply_points(const std::filesystem::path& path, const ReadOptions& options,
                     const detail::Allocation<Scalar>& allocation) {
  PlyFile ply(path);
  const PlyElement& vertices = find_ply_vertices(ply, options);
  const PointsHeader header = ply_header(vertices);
  ply.skip_to(vertices);
  PointsMap<Scalar> points = allocate(allocation, header);
  Scalar* point = points.data();
  for (std::uint64_t i = 0; i < header.count; ++i) {
    ply.read_item(vertices, i, [&](int axis, double value) {
      const auto x = static_cast<Scalar>(value);
      if (!std::isfinite(x))
        fail_ply_coordinate(ply, vertices, static_cast<std::int64_t>(i), axis, value);
      point[axis] = x;
    });
    point += header.dimension;
  }
}

template void read_ply_points(const std::filesystem::path&, const ReadOptions&,
                              const detail::Allocation<float>&);
template void read_ply_points(const std::filesystem::path&, const ReadOptions&,
                              const detail::Allocation<double>&);

}  // namespace ccvt::io
