#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>

#include "io/ply.h"
#include "io/records.h"

namespace ccvt::io {
namespace {

/// Where the normals are among the properties, if they are.
std::vector<std::size_t> find_ply_normals(const std::vector<PlyProperty>& properties) {
  std::vector<std::string> names;
  for (const PlyProperty& property : properties) {
    names.push_back(property.list ? std::string() : property.name);
  }
  return find_normals(names, [&](std::size_t k) { return properties[k].slot < 0; });
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
      dimension == 3 ? find_ply_normals(vertices.properties) : std::vector<std::size_t>();
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
