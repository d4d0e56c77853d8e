#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "ccvt/metrics.h"
#include "geometry/metric.h"
#include "metrics/sets.h"
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

/// The places where there are points, each once: coincident points share a cell.
struct Places {
  explicit Places(const PointSet& set) : of(static_cast<std::size_t>(set.count())) {
    const auto& points = set.points();
    std::vector<Index> order(of.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](Index p, Index q) {
      return std::tuple(points(0, p), points(1, p), p) < std::tuple(points(0, q), points(1, q), q);
    });
    for (const Index p : order) {
      const Vector2d at = points.col(p);
      if (count() == 0 || at != this->at(count() - 1)) {
        coordinates.insert(coordinates.end(), {at[0], at[1]});
      }
      of[static_cast<std::size_t>(p)] = count() - 1;
    }
  }

  [[nodiscard]] Index count() const { return static_cast<Index>(coordinates.size() / 2); }
  [[nodiscard]] Vector2d at(Index place) const {
    const double* const x = coordinates.data() + std::ptrdiff_t{2} * place;
    return {x[0], x[1]};
  }

  std::vector<double> coordinates;
  std::vector<Index> of;  ///< of each point
};

/// Cuts cells by the places around them.
class Cutter {
 public:
  Cutter(const Box& box, const Metric& metric, const Places& places, const SiteTree& tree)
      : box_(box), metric_(metric), places_(places), tree_(tree) {}

  /// By its neighbours in the order of their distance, until the next one is further than twice the
  /// cell's radius: no other can reach it. Of a cell that many may reach, as at the rim of a disc,
  /// all of these at once.
  [[nodiscard]] Cell cell_of(Index place) const {
    const Vector2d at = places_.at(place);
    const Vector2d extent = box_.extent();
    Cell cell = metric_.periodic() ? Cell({extent[0], extent[0], extent[1], extent[1]}, false)
                                   : Cell({at[0] - box_.lower[0], box_.upper[0] - at[0],
                                           at[1] - box_.lower[1], box_.upper[1] - at[1]},
                                          true);
    std::vector<Index> found;
    for (const int count : {16, 64}) {
      found.clear();
      tree_.nearest(at.data(), count, found);
      // The order of ties may change with their number: all are asked again.
      if (cut(place, found, cell) || std::ssize(found) == places_.count()) return cell;
    }
    found.clear();
    tree_.within(at.data(), 2 * std::sqrt(cell.squared_radius()), found);
    std::vector<std::pair<double, Index>> by_distance;
    for (const Index other : found) {
      by_distance.emplace_back(difference(at, other).squaredNorm(), other);
    }
    std::sort(by_distance.begin(), by_distance.end());
    for (std::size_t k = 0; k < found.size(); ++k) found[k] = by_distance[k].second;
    cut(place, found, cell);
    return cell;
  }

 private:
  [[nodiscard]] Vector2d difference(const Vector2d& at, Index other) const {
    const Vector2d there = places_.at(other);
    return {metric_.wrap(there[0] - at[0], 0), metric_.wrap(there[1] - at[1], 1)};
  }

  /// By these, which ascend by distance. True when one of them, and so all that come after it, is
  /// too far to reach the cell. On a torus all images are asked that may, of which the nearest
  /// comes in order.
  bool cut(Index place, std::span<const Index> others, Cell& cell) const {
    const Vector2d extent = box_.extent();
    const Vector2d at = places_.at(place);
    const int images = metric_.periodic() ? 1 : 0;
    for (const Index other : others) {
      const Vector2d nearest = difference(at, other);
      if (nearest.isZero(0)) continue;
      const double reach = 4 * cell.squared_radius();
      if (nearest.squaredNorm() > reach) return true;
      for (int y = -images; y <= images; ++y) {
        for (int x = -images; x <= images; ++x) {
          const Vector2d image = nearest + Vector2d(x * extent[0], y * extent[1]);
          if (image.squaredNorm() <= reach) cell.cut(image);
        }
      }
    }
    return false;
  }

  const Box& box_;
  const Metric& metric_;
  const Places& places_;
  const SiteTree& tree_;
};

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
  const Places places(set);
  const SiteTree tree(metric, places.coordinates);
  const Cutter cutter(set.domain().box(), metric, places, tree);
  std::vector<Bonds> of_place(static_cast<std::size_t>(places.count()));
  const double shortest = kShortestEdge * set.mean_spacing();
  arena.for_each(of_place.size(), 64, [&](std::size_t k) {
    of_place[k] = bonds_of(cutter.cell_of(static_cast<Index>(k)), shortest);
  });
  std::complex<double> sum = 0;
  double local = 0;
  double six = 0;
  double cells = 0;
  for (const Index place : places.of) {
    const Bonds& b = of_place[static_cast<std::size_t>(place)];
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
