#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "io/ply.h"
#include "io/records.h"

namespace ccvt::io {
namespace {

/// Where the normals are among the properties; empty unless there is one each of nx, ny and nz.
std::vector<std::size_t> find_normals(const std::vector<PlyProperty>& properties) {
  std::vector<std::size_t> at;
  for (const char axis : {'x', 'y', 'z'}) {
    for (std::size_t k = 0; k < properties.size(); ++k) {
      if (!properties[k].list && properties[k].name == std::string("n") + axis) at.push_back(k);
    }
  }
  const bool each_once = at.size() == 3 && properties[at[0]].name == "nx" &&
                         properties[at[1]].name == "ny" && properties[at[2]].name == "nz";
  const bool free = each_once && std::all_of(at.begin(), at.end(),
                                             [&](std::size_t k) { return properties[k].slot < 0; });
  return free ? at : std::vector<std::size_t>();
}

}  // namespace

PointCloud read_ply_cloud(const std::filesystem::path& path, const ReadOptions& options) {
  PlyFile ply(path);
  PlyElement& vertices = find_ply_vertices(ply, options);
  const PointsHeader header = ply_header(vertices);
  const int dimension = header.dimension;
  const auto count = static_cast<Index>(header.count);
  PointCloud cloud;
  cloud.scalar = header.scalar;
  cloud.points = {dimension, count};
  const auto normals =
      dimension == 3 ? find_normals(vertices.properties) : std::vector<std::size_t>();
  if (!normals.empty()) cloud.normals = {3, count};
  for (std::size_t k = 0; k < normals.size(); ++k) {
    vertices.properties[normals[k]].slot = dimension + static_cast<int>(k);
    vertices.properties[normals[k]].any = true;
  }
  for (const PlyProperty& property : vertices.properties) {
    if (property.slot < 0) cloud.kept.push_back(property.name);
  }
  for (const PlyElement& element : ply.elements()) {
    if (&element != &vertices) cloud.dropped.push_back(element.name);
  }
  auto records = std::make_shared<PointCloud::Records>();
  records->kind = PointCloud::Records::Kind::ply;
  records->encoding = ply.encoding();
  records->comments = ply.comments();
  records->properties = vertices.properties;
  ply.skip_to(vertices);
  ply.copy_to(&records->bytes);
  for (Index p = 0; p < count; ++p) {
    records->first.push_back(records->bytes.size());
    bool known = true;
    std::array<double, 3> normal{};
    ply.read_item(vertices, static_cast<std::uint64_t>(p), [&](int slot, double value) {
      if (slot < dimension) {
        if (!std::isfinite(value)) fail_ply_coordinate(ply, vertices, p, slot, value);
        cloud.points(slot, p) = value;
      } else {
        known = known && std::isfinite(value);
        normal.data()[slot - dimension] = value;
      }
    });
    if (normals.empty()) continue;
    if (!known) ++cloud.unknown_normals;
    for (int d = 0; d < 3; ++d) cloud.normals(d, p) = known ? normal.data()[d] : 0;
  }
  records->first.push_back(records->bytes.size());
  cloud.records = std::move(records);
  return cloud;
}

}  // namespace ccvt::io
