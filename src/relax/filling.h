#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "ccvt/types.h"
#include "relax/cells.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Points without a place in a cell, of the sites of one tile: a list for each site.
template <class Scalar>
class WaitingPoints {
 public:
  using Node = Number<struct OfNodes>;

  explicit WaitingPoints(std::size_t dimension) : dimension_(dimension) {}

  /// Puts a point at the head of a list, whose new head is returned.
  Node push(Node head, PointNumber point, const Scalar* x) {
    Node node = free_;
    if (free_ != Node::none()) {
      free_ = links_[free_].next;
    } else {
      node = Node(links_.size());
      links_.emplace_back();
      coordinates_.resize(coordinates_.size() + dimension_);
    }
    links_[node] = {point, head};
    std::copy_n(x, dimension_, coordinates_.data() + node * dimension_);
    return node;
  }
  /// Takes the head off a list; returns the new one. Both pointers hold until the next push().
  Node pop(Node head, PointNumber& point, const Scalar*& x) {
    Link& link = links_[head];
    point = link.point;
    x = coordinates_.data() + head * dimension_;
    const Node next = link.next;
    link.next = free_;
    free_ = head;
    return next;
  }

 private:
  struct Link {
    PointNumber point;
    Node next;
  };

  std::size_t dimension_;
  std::vector<Link> links_;  ///< by node
  std::vector<Scalar> coordinates_;
  Node free_ = Node::none();
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
        filled(target.site_count(), 0),
        waiting_(filled.size()),
        lists_(tiling.count(), WaitingPoints<Scalar>(target.dimension())) {}
  Filling(Cells<Scalar>& target, const PointsView<Scalar>& all_points)
      : Filling(target, all_points, Tiling(target.site_count(), 1)) {}

  /// Takes over the points of a cell; the site must have none yet, and room for all of them.
  void add_cell(const Cells<Scalar>& from, SiteNumber site) {
    cells.copy_points(from, site);
    filled[site] = from.size(site);
  }

  void add(SiteNumber site, PointNumber point, const Scalar* x) {
    Index& count = filled[site];
    if (count < cells.size(site)) {
      cells.put(site, count++, point, x);
    } else {
      Waiting& waiting = waiting_[site];
      waiting.head = list(site).push(waiting.head, point, x);
      ++waiting.count;
    }
  }
  void add(SiteNumber site, PointNumber point) { add(site, point, points[point.index()]); }

  /// Takes the point at place k out of a cell; the last point takes its place.
  PointNumber take(SiteNumber site, Index k) {
    Index& count = filled[site];
    const PointNumber point = cells.points(site).data()[k];
    --count;
    if (k != count) cells.copy_within(site, count, k);
    return point;
  }

  /// How many points of a site wait; and takes one of these.
  [[nodiscard]] Index waiting(SiteNumber site) const { return waiting_[site].count; }
  PointNumber take_waiting(SiteNumber site, const Scalar*& x) {
    PointNumber point;
    Waiting& waiting = waiting_[site];
    waiting.head = list(site).pop(waiting.head, point, x);
    --waiting.count;
    return point;
  }

  /// Points of a site beyond its capacity; negative where it lacks some.
  [[nodiscard]] Index surplus(SiteNumber site) const {
    return filled[site] + waiting(site) - cells.size(site);
  }

  Cells<Scalar>& cells;
  const PointsView<Scalar>& points;
  const Tiling tiles;
  std::vector<Index> filled;  ///< points in each cell

 private:
  struct Waiting {
    typename WaitingPoints<Scalar>::Node head = WaitingPoints<Scalar>::Node::none();
    Index count = 0;
  };
  WaitingPoints<Scalar>& list(SiteNumber site) { return lists_[tiles.tile_of(site)]; }

  std::vector<Waiting> waiting_;
  std::vector<WaitingPoints<Scalar>> lists_;  ///< by tile
};

}  // namespace ccvt
