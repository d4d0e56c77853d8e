#include "io/polygons.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace ccvt::io {

namespace {

using Vector = std::array<double, 3>;

struct Corner {
  double x, y;  ///< in the plane that the polygon is seen in, turning left
  Index vertex;
};

/// Twice the area of a triangle, negative where it turns right.
double turn(const Corner& a, const Corner& b, const Corner& c) {
  return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

bool in_one_place(const Corner& a, const Corner& b) { return a.x == b.x && a.y == b.y; }

/// The normals of the fan's triangles, twice their areas long.
std::vector<Vector> fan_normals(std::span<const Index> face, std::span<const double> coordinates) {
  const auto from_first = [&](std::size_t corner) {
    const double* const first = &coordinates[3 * static_cast<std::size_t>(face[0])];
    const double* const here = &coordinates[3 * static_cast<std::size_t>(face[corner])];
    return Vector{here[0] - first[0], here[1] - first[1], here[2] - first[2]};
  };
  std::vector<Vector> normals;
  for (std::size_t k = 2; k < face.size(); ++k) {
    const Vector a = from_first(k - 1);
    const Vector b = from_first(k);
    normals.push_back(
        {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]});
  }
  return normals;
}

/// The corners as seen along the axis that the normal is nearest to, from where they turn left.
std::vector<Corner> seen_along(const Vector& normal, std::span<const Index> face,
                               std::span<const double> coordinates) {
  const auto shorter = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto axis = static_cast<std::size_t>(
      std::max_element(normal.begin(), normal.end(), shorter) - normal.begin());
  std::size_t across = (axis + 1) % 3;
  std::size_t up = (axis + 2) % 3;
  if (normal.data()[axis] < 0) std::swap(across, up);
  std::vector<Corner> corners;
  for (const Index vertex : face) {
    const double* const at = &coordinates[3 * static_cast<std::size_t>(vertex)];
    corners.push_back({at[across], at[up], vertex});
  }
  return corners;
}

/// Whether the triangle at that corner can be cut off what is left of the polygon.
bool is_ear(const std::vector<Corner>& corners, std::size_t at) {
  const std::size_t count = corners.size();
  const std::size_t before = (at + count - 1) % count;
  const std::size_t after = (at + 1) % count;
  const Corner& a = corners[before];
  const Corner& b = corners[at];
  const Corner& c = corners[after];
  if (!(turn(a, b, c) > 0)) return false;
  for (std::size_t k = 0; k < count; ++k) {
    const Corner& p = corners[k];
    if (k == before || k == at || k == after || in_one_place(p, a) || in_one_place(p, b) ||
        in_one_place(p, c)) {
      continue;
    }
    if (turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

std::vector<Index> divide_concave(std::span<const Index> face,
                                  std::span<const double> coordinates) {
  const std::vector<Vector> normals = fan_normals(face, coordinates);
  Vector normal{};
  for (const Vector& one : normals) {
    for (std::size_t d = 0; d < 3; ++d) normal.data()[d] += one.data()[d];
  }
  const bool turns_back = std::any_of(normals.begin(), normals.end(), [&](const Vector& one) {
    return one[0] * normal[0] + one[1] * normal[1] + one[2] * normal[2] < 0;
  });
  if (!turns_back) return {};
  std::vector<Corner> corners = seen_along(normal, face, coordinates);
  std::vector<Index> triangles;
  std::size_t at = 0;
  for (std::size_t tried = 0; corners.size() > 3;) {
    const std::size_t count = corners.size();
    if (tried == count) return {};
    at %= count;
    const std::size_t before = (at + count - 1) % count;
    // A corner on the line between its neighbours is cut off without area.
    const bool straight = turn(corners[before], corners[at], corners[(at + 1) % count]) == 0;
    if (!straight && !is_ear(corners, at)) {
      ++at;
      ++tried;
      continue;
    }
    triangles.insert(triangles.end(), {corners[before].vertex, corners[at].vertex,
                                       corners[(at + 1) % count].vertex});
    corners.erase(corners.begin() + static_cast<std::ptrdiff_t>(at));
    tried = 0;
  }
  for (const Corner& corner : corners) triangles.push_back(corner.vertex);
  return triangles;
}

}  // namespace ccvt::io
