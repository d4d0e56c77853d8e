#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <string>
#include <vector>

#include "ccvt/metrics.h"
#include "geometry/metric.h"
#include "metrics/sets.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "spatial/site_tree.h"
#include "thread_count.h"

namespace ccvt {

namespace {

using Eigen::Vector2d;

constexpr double kShortestEdge = 1e-4;  ///< in mean spacings

/// The Voronoi cell of a point at the origin: a convex polygon that is cut along bisectors.
class Cell {
 public:
  struct Edge {
    Vector2d start;      ///< the edge ends where the next one starts
    Vector2d neighbour;  ///< relative to the point
    bool border = false;
  };

  /// A rectangle around the point: its half of the way to `sides` (left, right, down, up), which
  /// are neighbours, or the border of the box.
  Cell(const std::array<double, 4>& sides, bool border) {
    const double scale = border ? 1 : 0.5;
    const double left = -sides[0] * scale;
    const double right = sides[1] * scale;
    const double down = -sides[2] * scale;
    const double up = sides[3] * scale;
    edges_ = {{{left, down}, {0, -sides[2]}, border},
              {{right, down}, {sides[1], 0}, border},
              {{right, up}, {0, sides[3]}, border},
              {{left, up}, {-sides[0], 0}, border}};
  }

  /// Keeps the part that is nearer to the origin than to `other`. Corners on the bisector, but for
  /// rounding, stay as they are: else an edge along it, cut once more, would fall in two.
  void cut(const Vector2d& other) {
    const double rounding = 1e-12 * other.norm() * (other.norm() + std::sqrt(squared_radius()));
    const double limit = other.squaredNorm() / 2;
    const auto beyond = [&](const Edge& edge) { return edge.start.dot(other) - limit; };
    if (std::none_of(edges_.begin(), edges_.end(),
                     [&](const Edge& edge) { return beyond(edge) > rounding; })) {
      return;
    }
    next_.clear();
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const Edge& edge = edges_[e];
      const Edge& after = edges_[(e + 1) % edges_.size()];
      const double here = beyond(edge);
      const double there = beyond(after);
      if (here <= rounding) next_.push_back(edge);
      if ((here <= rounding) == (there <= rounding)) continue;
      const Vector2d crossing = edge.start + here / (here - there) * (after.start - edge.start);
      if (here <= rounding) {  // leaves: the bisector starts here
        next_.push_back({crossing, other, false});
      } else {
        next_.push_back({crossing, edge.neighbour, edge.border});
      }
    }
    edges_.swap(next_);
  }

  [[nodiscard]] double squared_radius() const {
    double largest = 0;
    for (const Edge& edge : edges_) largest = std::max(largest, edge.start.squaredNorm());
    return largest;
  }

  /// Calls visit(neighbour, border) for the edges longer than `shortest`.
  template <class Visit>
  void for_each_edge(double shortest, Visit visit) const {
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const Edge& edge = edges_[e];
      const double length = (edges_[(e + 1) % edges_.size()].start - edge.start).norm();
      if (length > shortest) visit(edge.neighbour, edge.border);
    }
  }

 private:
  std::vector<Edge> edges_;
  std::vector<Edge> next_;
};

/// Cuts the cell of `p` by its neighbours in the order of their distance, until the next one is
/// further than twice the cell's radius: no other can reach it. On a torus all images are asked
/// that may, of which the nearest comes in order.
Cell cell_of(const PointSet& set, const Metric& metric, const SiteTree& tree, PointNumber p) {
  const Box& box = set.domain().box();
  const Vector2d at = set.points().col(p.index());
  const Vector2d extent = box.extent();
  const bool periodic = metric.periodic();
  Cell cell = periodic ? Cell({extent[0], extent[0], extent[1], extent[1]}, false)
                       : Cell({at[0] - box.lower[0], box.upper[0] - at[0], at[1] - box.lower[1],
                               box.upper[1] - at[1]},
                              true);
  std::vector<Index> found;
  std::ptrdiff_t done = 0;
  for (int k = 16; done < set.count(); k *= 4) {
    found.clear();
    tree.nearest(at.data(), k, found);
    // The order of ties may change with k: all are asked again.
    for (const Index q : found) {
      if (q == p.index()) continue;
      const Vector2d other = set.points().col(q);
      Vector2d difference(metric.wrap(other[0] - at[0], 0), metric.wrap(other[1] - at[1], 1));
      if (difference.isZero(0)) continue;
      const double reach = 4 * cell.squared_radius();
      if (difference.squaredNorm() > reach) return cell;
      const int images = periodic ? 1 : 0;
      for (int y = -images; y <= images; ++y) {
        for (int x = -images; x <= images; ++x) {
          const Vector2d image = difference + Vector2d(x * extent[0], y * extent[1]);
          if (image.squaredNorm() <= reach) cell.cut(image);
        }
      }
    }
    done = std::ssize(found);
  }
  return cell;
}

struct Bonds {
  std::complex<double> psi;
  int neighbours = 0;
  bool inner = true;  ///< does not touch the border
};

Bonds bonds_of(const Cell& cell, double shortest) {
  Bonds bonds;
  cell.for_each_edge(shortest, [&](const Vector2d& neighbour, bool border) {
    if (border) bonds.inner = false;
    bonds.psi += std::polar(1.0, 6 * std::atan2(neighbour[1], neighbour[0]));
    ++bonds.neighbours;
  });
  if (bonds.neighbours > 0) bonds.psi /= bonds.neighbours;
  return bonds;
}

}  // namespace

BondOrder bond_order(const PointSet& set, int threads) {
  require_points(set);
  require_threads(threads);
  return bond_order(set, Arena(threads));
}

BondOrder bond_order(const PointSet& set, const Arena& arena) {
  if (set.dimension() != 2) {
    throw InvalidInput("set: has " + std::to_string(set.dimension()) +
                       " dimensions; bond order is that of two");
  }
  const Metric metric(2, set.domain());
  const SiteTree tree(metric, coordinates_of(set));
  std::vector<Bonds> bonds(static_cast<std::size_t>(set.count()));
  const double shortest = kShortestEdge * set.mean_spacing();
  arena.for_each(bonds.size(), 64, [&](std::size_t p) {
    bonds[p] = bonds_of(cell_of(set, metric, tree, PointNumber(p)), shortest);
  });
  std::complex<double> sum = 0;
  double local = 0;
  double six = 0;
  double cells = 0;
  for (const Bonds& b : bonds) {
    if (!b.inner) continue;
    sum += b.psi;
    local += std::abs(b.psi);
    six += b.neighbours == 6 ? 1 : 0;
    ++cells;
  }
  if (cells == 0) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none, none};
  }
  return {local / cells, std::abs(sum) / cells, six / cells};
}

}  // namespace ccvt
