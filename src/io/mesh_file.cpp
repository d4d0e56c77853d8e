#include "io/mesh_file.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "io/formats.h"
#include "io/ply_file.h"
#include "io/polygons.h"
#include "number_text.h"

namespace ccvt::io {

namespace {

constexpr int kDensity = 3;  // the slot after the coordinates

void choose_vertex_properties(PlyFile& ply, PlyElement& vertices, const std::string& density) {
  const auto choose = [&](const std::string& name, int slot) {
    int found = 0;
    for (PlyProperty& property : vertices.properties) {
      if (property.list || property.name != name) continue;
      property.slot = slot;
      ++found;
    }
    return found == 1;
  };
  if (!choose("x", 0) || !choose("y", 1) || !choose("z", 2)) {
    ply.file().fail("vertices need one x, one y and one z");
  }
  if (density.empty()) return;
  if (density == "x" || density == "y" || density == "z") {
    ply.file().fail("the property " + io::quoted(density) + " is a coordinate, and no density");
  }
  if (!choose(density, kDensity)) {
    std::string names;
    for (const PlyProperty& property : vertices.properties) {
      if (!property.list) names += (names.empty() ? "" : ", ") + property.name.substr(0, 40);
    }
    ply.file().fail("vertices have no property " + io::quoted(density) + "; they have " +
                    names.substr(0, 400));
  }
}

void choose_corners(PlyFile& ply, PlyElement& faces) {
  for (PlyProperty& property : faces.properties) {
    if (!property.list || (property.name != "vertex_indices" && property.name != "vertex_index")) {
      continue;
    }
    property.slot = 0;
    return;
  }
  ply.file().fail("faces need the list vertex_indices or vertex_index");
}

void read_vertices(PlyFile& ply, const PlyElement& vertices, bool density, MeshParts& parts) {
  parts.coordinates.resize(3 * vertices.count);
  if (density) parts.density.resize(vertices.count);
  for (std::size_t v = 0; v < vertices.count; ++v) {
    ply.read_item(vertices, v, [&](int slot, double value) {
      const bool coordinate = slot < kDensity;
      if (!std::isfinite(value) || (!coordinate && value < 0)) {
        ply.file().fail(concat(
            "vertex ", v, ": ", coordinate ? std::string(1, "xyz"[slot]) : "the density", " is ",
            value, coordinate ? "; must be finite" : "; must be finite and not negative"));
      }
      if (coordinate) {
        parts.coordinates[3 * v + static_cast<std::size_t>(slot)] = value;
      } else {
        parts.density[v] = value;
      }
    });
  }
}

void read_faces(PlyFile& ply, const PlyElement& faces, std::uint64_t vertices, MeshParts& parts) {
  std::vector<Index> face;
  for (std::uint64_t f = 0; f < faces.count; ++f) {
    face.clear();
    ply.read_item(faces, f, [&](int, double corner) {
      if (!(corner >= 0 && corner < static_cast<double>(vertices) &&
            corner == std::floor(corner))) {
        ply.file().fail(concat("face ", f, ": corner ", face.size(), " is vertex ", corner,
                               "; vertices have the numbers 0 to ", vertices - 1));
      }
      face.push_back(static_cast<Index>(corner));
    });
    if (face.size() < 3) {
      ply.file().fail(concat("face ", f, ": has ", face.size(), " corners; needs at least 3"));
    }
    parts.add_face(ply.file(), face);
  }
}

MeshParts read_ply_mesh(const std::filesystem::path& path, const std::string& density) {
  PlyFile ply(path);
  PlyElement* const vertices = ply.find("vertex");
  PlyElement* const faces = ply.find("face");
  if (vertices == nullptr) ply.file().fail("has no element 'vertex'");
  if (faces == nullptr) ply.file().fail("has no element 'face': it holds no surface");
  choose_vertex_properties(ply, *vertices, density);
  choose_corners(ply, *faces);
  ply.check_count(*vertices);
  ply.check_count(*faces);
  MeshParts parts;
  int left = 2;
  for (const PlyElement& element : ply.elements()) {
    if (left == 0) break;
    if (&element == vertices) {
      read_vertices(ply, *vertices, !density.empty(), parts);
      --left;
    } else if (&element == faces) {
      read_faces(ply, *faces, vertices->count, parts);
      --left;
    } else {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        ply.read_item(element, i, [](int, double) {});
      }
    }
  }
  return parts;
}

}  // namespace

void MeshParts::add_face(const InputFile& file, std::span<const Index> face) {
  constexpr std::size_t kMost = std::numeric_limits<Index>::max();
  if (corners.size() / 3 + face.size() > kMost) {
    file.fail(concat("has more than ", kMost, " triangles, which is the most supported"));
  }
  if (face.size() > 3) fans_.push_back({corners.size(), face.size() - 2});
  for (std::size_t k = 2; k < face.size(); ++k) {
    corners.insert(corners.end(), {face[0], face[k - 1], face[k]});
  }
}

void MeshParts::divide_concave_faces() {
  std::vector<Index> face;
  for (const Fan& fan : fans_) {
    const auto triangles = std::span(corners).subspan(fan.first, 3 * fan.triangles);
    face.assign(triangles.begin(), triangles.begin() + 2);
    for (std::size_t k = 2; k < triangles.size(); k += 3) face.push_back(triangles[k]);
    const std::vector<Index> divided = divide_concave(face, coordinates);
    std::copy(divided.begin(), divided.end(), triangles.begin());
  }
}

}  // namespace ccvt::io

namespace ccvt {

TriangleMesh read_mesh(const std::filesystem::path& path, const std::string& density) {
  const std::string extension = io::extension_of(path);
  if (!io::is_among(io::kMeshFiles, extension)) {
    throw InvalidInput(path.string() + ": unknown extension " + io::quoted(extension) +
                       "; meshes are read from " + io::list_of(io::kMeshFiles, " or "));
  }
  io::MeshParts parts =
      extension == ".obj" ? io::read_obj(path, density) : io::read_ply_mesh(path, density);
  parts.divide_concave_faces();
  TriangleMesh mesh;
  mesh.vertices = Columns<double>(3, std::ssize(parts.coordinates) / 3);
  std::copy(parts.coordinates.begin(), parts.coordinates.end(), mesh.vertices.data());
  parts.coordinates = {};
  mesh.triangles = Columns<Index>(3, std::ssize(parts.corners) / 3);
  std::copy(parts.corners.begin(), parts.corners.end(), mesh.triangles.data());
  mesh.density = std::move(parts.density);
  try {
    mesh.validate();
  } catch (const InvalidInput& error) {
    throw InvalidInput(path.string() + ": " + error.what());
  }
  return mesh;
}

}  // namespace ccvt
