#include "surface/sheets.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <tuple>
#include <utility>

#include "numbers.h"

namespace ccvt {

namespace {

using TriangleNumber = Number<struct OfTriangles>;
using VertexNumber = Number<struct OfVertices>;

/// For each vertex the first one at the same place.
std::vector<Index> welded(const TriangleMesh& mesh) {
  const auto vertices = static_cast<std::size_t>(mesh.vertices.cols());
  const double* const at = mesh.vertices.data();
  const auto place = [at](Index v) {
    const double* const x = at + std::ptrdiff_t{3} * v;
    return std::tuple(x[0], x[1], x[2]);
  };
  std::vector<Index> order(vertices);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return std::tuple(place(a), a) < std::tuple(place(b), b); });
  std::vector<Index> first(vertices);
  for (std::size_t k = 0; k < vertices; ++k) {
    const bool same = k > 0 && place(order[k]) == place(order[k - 1]);
    first[VertexNumber(order[k])] = same ? first[VertexNumber(order[k - 1])] : order[k];
  }
  return first;
}

/// One side of a triangle, from the lower to the higher of its ends, or against that.
struct Side {
  Index low;
  Index high;
  Index triangle;
  bool against;

  [[nodiscard]] bool along(const Side& other) const {
    return low == other.low && high == other.high;
  }
  friend bool operator<(const Side& a, const Side& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  }
};

std::vector<Side> sides_of(const TriangleMesh& mesh, const std::vector<double>& areas) {
  const std::vector<Index> first = welded(mesh);
  std::vector<Side> sides;
  sides.reserve(3 * areas.size());
  for (const TriangleNumber t : numbers_below<TriangleNumber>(areas.size())) {
    if (!(areas[t] > 0)) continue;
    for (std::ptrdiff_t k = 0; k < 3; ++k) {
      const Index a = first[VertexNumber(mesh.triangles(k, t.index()))];
      const Index b = first[VertexNumber(mesh.triangles((k + 1) % 3, t.index()))];
      sides.push_back({std::min(a, b), std::max(a, b), t.index(), a > b});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

/// Sets of triangles that are joined, each facing as the first of its set or against it.
class Joined {
 public:
  explicit Joined(std::size_t count) : parent_(count), against_(count, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  /// The first of its set, and whether it faces against that.
  std::pair<Index, bool> find(Index triangle) {
    Index root = triangle;
    bool against = false;
    while (parent_[TriangleNumber(root)] != root) {
      against = against != (against_[TriangleNumber(root)] != 0);
      root = parent_[TriangleNumber(root)];
    }
    // All on the way become children of the root.
    for (bool left = against; triangle != root;) {
      const TriangleNumber t(triangle);
      const bool step = against_[t] != 0;
      triangle = std::exchange(parent_[t], root);
      against_[t] = left ? 1 : 0;
      left = left != step;
    }
    return {root, against};
  }

  void join(Index a, Index b, bool against) {
    const auto [root_a, from_a] = find(a);
    const auto [root_b, from_b] = find(b);
    if (root_a == root_b) return;  // of a surface with one side, the last edge does not agree
    const auto [low, high] = std::minmax(root_a, root_b);
    parent_[TriangleNumber(high)] = low;
    against_[TriangleNumber(high)] = (from_a != from_b) != against ? 1 : 0;
  }

 private:
  std::vector<Index> parent_;
  std::vector<std::uint8_t> against_;
};

}  // namespace

Sheets find_sheets(const TriangleMesh& mesh, const std::vector<double>& areas, Stop& stop) {
  Joined joined(areas.size());
  const std::vector<Side> sides = sides_of(mesh, areas);
  stop.check();
  for (std::size_t begin = 0; begin < sides.size();) {
    std::size_t end = begin + 1;
    while (end < sides.size() && sides[end].along(sides[begin])) ++end;
    const Side& a = sides[begin];
    const Side& b = sides[end - 1];
    // Neighbours that agree run along their edge in opposite directions.
    if (end == begin + 2) joined.join(a.triangle, b.triangle, a.against == b.against);
    begin = end;
  }
  stop.check();

  Sheets sheets;
  sheets.sheet.assign(areas.size(), -1);
  sheets.turned.assign(areas.size(), 0);
  std::vector<Index> sheet_of_root(areas.size(), -1);
  std::vector<double> balance;  // the area that faces as the first triangle, less the other
  for (const TriangleNumber t : numbers_below<TriangleNumber>(areas.size())) {
    if (!(areas[t] > 0)) continue;
    const auto [root, against] = joined.find(t.index());
    Index& sheet = sheet_of_root[TriangleNumber(root)];
    if (sheet < 0) {
      sheet = sheets.count++;
      balance.push_back(0);
    }
    sheets.sheet[t] = sheet;
    sheets.turned[t] = against ? 1 : 0;
    balance[static_cast<std::size_t>(sheet)] += against ? -areas[t] : areas[t];
  }
  for (const TriangleNumber t : numbers_below<TriangleNumber>(areas.size())) {
    if (sheets.sheet[t] < 0) continue;
    if (balance[static_cast<std::size_t>(sheets.sheet[t])] < 0) sheets.turned[t] ^= 1U;
  }
  return sheets;
}

}  // namespace ccvt
