#include <algorithm>
#include <cmath>

#include "ccvt/surface.h"
#include "no_checkpoint.h"
#include "number_text.h"
#include "surface/triangles.h"

namespace ccvt {

namespace {

constexpr double kLeastExtent = 1e-25;
constexpr double kMostExtent = 1e15;

void check_vertices(const TriangleMesh& mesh) {
  const std::ptrdiff_t vertices = mesh.vertices.cols();
  if (mesh.vertices.rows() != 3 || vertices == 0) {
    throw InvalidInput(concat("mesh: vertices are ", mesh.vertices.rows(), " x ", vertices,
                              "; needs 3 rows, and a column for each"));
  }
  for (std::ptrdiff_t v = 0; v < vertices; ++v) {
    for (std::ptrdiff_t d = 0; d < 3; ++d) {
      if (std::isfinite(mesh.vertices(d, v))) continue;
      throw InvalidInput(concat("mesh: coordinate ", d, " of vertex ", v, " is ",
                                mesh.vertices(d, v), "; must be finite"));
    }
  }
}

void check_corners(const TriangleMesh& mesh) {
  const std::ptrdiff_t vertices = mesh.vertices.cols();
  const std::ptrdiff_t triangles = mesh.triangles.cols();
  if (mesh.triangles.rows() != 3 || triangles == 0 || triangles > INT32_MAX) {
    throw InvalidInput(concat("mesh: triangles are ", mesh.triangles.rows(), " x ", triangles,
                              "; needs 3 rows, and a column for each, at most 2147483647"));
  }
  for (std::ptrdiff_t t = 0; t < triangles; ++t) {
    for (std::ptrdiff_t i = 0; i < 3; ++i) {
      const Index corner = mesh.triangles(i, t);
      if (corner >= 0 && corner < vertices) continue;
      throw InvalidInput(concat("mesh: corner ", i, " of triangle ", t, " is vertex ", corner,
                                "; vertices have the numbers 0 to ", vertices - 1));
    }
  }
}

void check_density(const TriangleMesh& mesh) {
  const std::ptrdiff_t vertices = mesh.vertices.cols();
  if (!mesh.density.empty() && std::ssize(mesh.density) != vertices) {
    throw InvalidInput(concat("mesh: has ", mesh.density.size(), " densities for ", vertices,
                              " vertices; needs one for each, or none"));
  }
  const auto wrong = std::find_if(mesh.density.begin(), mesh.density.end(), [](double density) {
    return !(density >= 0 && std::isfinite(density));
  });
  if (wrong == mesh.density.end()) return;
  throw InvalidInput(concat("mesh: the density of vertex ", wrong - mesh.density.begin(), " is ",
                            *wrong, "; must be finite and not negative"));
}

}  // namespace

void TriangleMesh::validate() const {
  check_vertices(*this);
  check_corners(*this);
  check_density(*this);
  const double extent = box_around(*this).sizes().maxCoeff();
  if (extent >= kLeastExtent && extent <= kMostExtent) return;
  throw InvalidInput(concat("mesh: its triangles extend over ", extent, "; must be from ",
                            kLeastExtent, " to ", kMostExtent));
}

void SurfaceOptions::validate() const {
  if (points_per_site < 1) {
    throw InvalidInput(concat("points_per_site: is ", points_per_site, "; must be at least 1"));
  }
  if (!(normal_weight >= 0 && normal_weight <= 100)) {
    throw InvalidInput(concat("normal_weight: is ", normal_weight, "; must be from 0 to 100"));
  }
  tessellation.validate();
  require_no_checkpoint(tessellation, "sample_surface()");
}

}  // namespace ccvt
