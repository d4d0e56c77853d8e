#include "io/polygons.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <utility>

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

/// The normal of the fan's triangle that ends at that corner, twice its area long.
Vector fan_normal(std::span<const Index> face, std::span<const double> coordinates,
                  std::size_t corner) {
  const double* const first = &coordinates[3 * static_cast<std::size_t>(face[0])];
  const auto from_first = [&](std::size_t at) {
    const double* const here = &coordinates[3 * static_cast<std::size_t>(face[at])];
    return Vector{here[0] - first[0], here[1] - first[1], here[2] - first[2]};
  };
  const Vector a = from_first(corner - 1);
  const Vector b = from_first(corner);
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
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

/// What is left of a polygon while corners are cut off.
class Rest {
 public:
  /// `margin`: twice the area of triangles that are taken for none. `looks`: how many corners may
  /// still be looked at, for all that share the count.
  Rest(std::vector<Corner> corners, double margin, std::int64_t& looks)
      : corners_(std::move(corners)), margin_(margin), looks_(looks) {}

  /// Cuts off all corners, beginning at one of them; appends three for each triangle. False where
  /// none of those left can be cut off, or that takes too long to find out.
  bool divide(std::size_t at, std::vector<Corner>& triangles) {
    for (std::size_t tried = 0; corners_.size() > 3;) {
      if (tried == corners_.size() || looks_ <= 0) return false;
      at %= corners_.size();
      if (!is_straight(at) && !is_ear(at)) {
        ++at;
        ++tried;
        continue;
      }
      triangles.insert(triangles.end(), {corners_[before(at)], corners_[at], corners_[after(at)]});
      corners_.erase(corners_.begin() + static_cast<std::ptrdiff_t>(at));
      tried = 0;
    }
    triangles.insert(triangles.end(), corners_.begin(), corners_.end());
    return true;
  }

 private:
  [[nodiscard]] std::size_t before(std::size_t at) const {
    return (at + corners_.size() - 1) % corners_.size();
  }
  [[nodiscard]] std::size_t after(std::size_t at) const { return (at + 1) % corners_.size(); }
  /// On the line between its neighbours: it is cut off without area.
  [[nodiscard]] bool is_straight(std::size_t at) const {
    return std::abs(turn(corners_[before(at)], corners_[at], corners_[after(at)])) <= margin_;
  }
  /// Whether no other corner, and no side that leads through this one, is in the triangle.
  [[nodiscard]] bool is_ear(std::size_t at) {
    const Corner& a = corners_[before(at)];
    const Corner& b = corners_[at];
    const Corner& c = corners_[after(at)];
    if (!(turn(a, b, c) > margin_)) return false;
    const auto in_wedge = [&](const Corner& p) {
      return turn(a, b, p) > margin_ && turn(b, c, p) > margin_;
    };
    for (std::size_t k = 0; k < corners_.size(); ++k, --looks_) {
      const Corner& p = corners_[k];
      if (k == at || in_one_place(p, a) || in_one_place(p, c)) continue;
      if (in_one_place(p, b)) {
        if (in_wedge(corners_[before(k)]) || in_wedge(corners_[after(k)])) return false;
      } else if (turn(a, b, p) >= -margin_ && turn(b, c, p) >= -margin_ &&
                 turn(c, a, p) >= -margin_) {
        return false;
      }
    }
    return true;
  }

  std::vector<Corner> corners_;
  double margin_;
  std::int64_t& looks_;
};

}  // namespace

std::vector<Index> divide_concave(std::span<const Index> face,
                                  std::span<const double> coordinates) {
  constexpr std::array kMargins = {1e-12, 1e-9, 0.0};  // of twice the polygon's area
  constexpr std::size_t kMostStarts = 8;
  constexpr double kRounding = 1e-9;
  // A face of 100,000 corners takes 5e9 at most; one that crosses itself, the cube of the corners.
  constexpr std::int64_t kMostLooks = std::int64_t{1} << 34;
  const auto dot = [](const Vector& a, const Vector& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  };
  Vector normal{};
  for (std::size_t k = 2; k < face.size(); ++k) {
    const Vector one = fan_normal(face, coordinates, k);
    for (std::size_t d = 0; d < 3; ++d) normal.data()[d] += one.data()[d];
  }
  bool turns_back = false;
  for (std::size_t k = 2; k < face.size(); ++k) {
    turns_back = turns_back || dot(fan_normal(face, coordinates, k), normal) < 0;
  }
  if (!turns_back) return {};
  const std::vector<Corner> corners = seen_along(normal, face, coordinates);
  double area = 0;
  for (std::size_t k = 2; k < corners.size(); ++k) {
    area += turn(corners[0], corners[k - 1], corners[k]);
  }
  std::vector<Corner> triangles;
  std::int64_t looks = kMostLooks;
  for (const double margin : kMargins) {
    for (std::size_t start = 0; start < std::min(kMostStarts, corners.size()); ++start) {
      triangles.clear();
      if (!Rest(corners, margin * area, looks).divide(start, triangles)) continue;
      // None turns back: else all of them together are larger.
      double sum = 0;
      for (std::size_t k = 0; k < triangles.size(); k += 3) {
        sum += std::abs(turn(triangles[k], triangles[k + 1], triangles[k + 2]));
      }
      if (!(sum <= area * (1 + kRounding))) continue;
      std::vector<Index> result;
      for (const Corner& corner : triangles) result.push_back(corner.vertex);
      return result;
    }
  }
  return {};
}

}  // namespace ccvt::io
