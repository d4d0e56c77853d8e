#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Points without a place in a cell, of the sites of one tile: a list for each site.
template <class Scalar>
class WaitingPoints {
 public:
  explicit WaitingPoints(int dimension) : dimension_(static_cast<std::size_t>(dimension)) {}

  /// Puts a point at the head of a list, whose new head is returned.
  Index push(Index head, Index point, const Scalar* x) {
    const Index node = free_ >= 0 ? free_ : static_cast<Index>(nodes_.size());
    if (free_ >= 0) {
      free_ = nodes_[at(node)].next;
    } else {
      nodes_.emplace_back();
      coordinates_.resize(coordinates_.size() + dimension_);
    }
    nodes_[at(node)] = {point, head};
    std::copy_n(x, dimension_, coordinates_.begin() + offset(node));
    return node;
  }
  /// Takes the head off a list; returns the new one. Both pointers hold until the next push().
  Index pop(Index head, Index& point, const Scalar*& x) {
    Node& node = nodes_[at(head)];
    point = node.point;
    x = coordinates_.data() + offset(head);
    const Index next = node.next;
    node.next = free_;
    free_ = head;
    return next;
  }

 private:
  struct Node {
    Index point;
    Index next;
  };
  static std::size_t at(Index node) { return static_cast<std::size_t>(node); }
  [[nodiscard]] std::ptrdiff_t offset(Index node) const {
    return static_cast<std::ptrdiff_t>(at(node) * dimension_);
  }

  std::size_t dimension_;
  std::vector<Node> nodes_;
  std::vector<Scalar> coordinates_;
  Index free_ = -1;
};

/// Cells that are being filled with points. A site may take more points than its cell has room
/// for; the others wait, and must move on before the tessellation is complete. Sites of different
/// tiles may be used at the same time.
template <class Scalar>
class Filling {
 public:
  Filling(Cells<Scalar>& target, const PointsView<Scalar>& all_points, const Tiling& tiling)
      : cells(target),
        points(all_points),
        tiles(tiling),
        filled(static_cast<std::size_t>(target.site_count()), 0),
        waiting_(filled.size()),
        lists_(tiling.count(), WaitingPoints<Scalar>(target.dimension())) {}
  Filling(Cells<Scalar>& target, const PointsView<Scalar>& all_points)
      : Filling(target, all_points, Tiling(target.site_count(), 1)) {}

  /// Takes over the points of a cell; the site must have none yet, and room for all of them.
  void add_cell(const Cells<Scalar>& from, Index site) {
    cells.copy_points(from, site);
    filled[at(site)] = from.size(site);
  }

  void add(Index site, Index point, const Scalar* x) {
    Index& count = filled[at(site)];
    if (count < cells.size(site)) {
      cells.put(site, count++, point, x);
    } else {
      Waiting& waiting = waiting_[at(site)];
      waiting.head = list(site).push(waiting.head, point, x);
      ++waiting.count;
    }
  }
  void add(Index site, Index point) { add(site, point, points[point]); }

  /// Takes the point at place k out of a cell; the last point takes its place.
  Index take(Index site, Index k) {
    Index& count = filled[at(site)];
    const Index point = cells.points(site)[k];
    --count;
    if (k != count) cells.copy_within(site, count, k);
    return point;
  }

  /// How many points of a site wait; and takes one of these.
  [[nodiscard]] Index waiting(Index site) const { return waiting_[at(site)].count; }
  Index take_waiting(Index site, const Scalar*& x) {
    Index point = -1;
    Waiting& waiting = waiting_[at(site)];
    waiting.head = list(site).pop(waiting.head, point, x);
    --waiting.count;
    return point;
  }

  /// Points of a site beyond its capacity; negative where it lacks some.
  [[nodiscard]] Index surplus(Index site) const {
    return filled[at(site)] + waiting(site) - cells.size(site);
  }

  Cells<Scalar>& cells;
  const PointsView<Scalar>& points;
  const Tiling tiles;
  std::vector<Index> filled;  ///< points in each cell

 private:
  struct Waiting {
    Index head = -1;
    Index count = 0;
  };
  static std::size_t at(Index site) { return static_cast<std::size_t>(site); }
  WaitingPoints<Scalar>& list(Index site) { return lists_[at(tiles.tile_of(site).number)]; }

  std::vector<Waiting> waiting_;
  std::vector<WaitingPoints<Scalar>> lists_;  ///< by tile
};

}  // namespace ccvt
