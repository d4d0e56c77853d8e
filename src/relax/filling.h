#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "ccvt/types.h"
#include "relax/cells.h"
#include "relax/own_points.h"
#include "schedule/tiling.h"

namespace ccvt {

/// Points without a place in a cell, of the sites of one tile: a list for each site.
template <class Scalar>
class WaitingPoints {
 public:
  using Node = Number<struct OfNodes>;

  explicit WaitingPoints(std::size_t dimension) : dimension_(dimension) {}

  /// Puts a point at the head of a list, whose new head is returned.
  Node push(Node head, PointOfAll point, const Scalar* x) {
    Node node = free_;
    if (free_ != Node::none()) {
      free_ = links_[free_].next;
    } else {
      if (links_.size() == kMost) throw std::length_error("more points wait than can be numbered");
      node = Node(links_.size());
      links_.emplace_back();
      coordinates_.resize(coordinates_.size() + dimension_);
    }
    links_[node] = {point, head};
    std::copy_n(x, dimension_, coordinates_.data() + node * dimension_);
    return node;
  }
  [[nodiscard]] Node next(Node node) const { return links_[node].next; }
  [[nodiscard]] PointOfAll point(Node node) const { return links_[node].point; }
  [[nodiscard]] const Scalar* coordinates(Node node) const {
    return coordinates_.data() + node * dimension_;
  }
  /// Takes the head off a list; returns the new one. Both pointers hold until the next push().
  Node pop(Node head, PointOfAll& point, const Scalar*& x) {
    Link& link = links_[head];
    point = link.point;
    x = coordinates_.data() + head * dimension_;
    const Node next = link.next;
    link.next = free_;
    free_ = head;
    return next;
  }

 private:
  static constexpr auto kMost = static_cast<std::size_t>(std::numeric_limits<Index>::max());
  struct Link {
    PointOfAll point;
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
  Filling(Cells<Scalar>& target, const OwnPoints<Scalar>& own_points, const Tiling& tiling)
      : cells(target),
        points(own_points),
        tiles(tiling),
        filled(target.site_count(), 0),
        waiting_(filled.size()),
        lists_(tiling.count(), WaitingPoints<Scalar>(target.dimension())) {}
  Filling(Cells<Scalar>& target, const OwnPoints<Scalar>& own_points)
      : Filling(target, own_points, Tiling(target.site_count(), 1)) {}

  /// Takes over the points of a cell; the site must have none yet, and room for all of them.
  void add_cell(const Cells<Scalar>& from, SiteNumber site) {
    cells.copy_points(from, site);
    filled[site] = from.size(site);
  }

  void add(SiteNumber site, PointOfAll point, const Scalar* x) {
    note(site, point, 1);
    Index& count = filled[site];
    if (count < cells.size(site)) {
      cells.put(site, count++, point, x);
    } else {
      Waiting& waiting = waiting_[site];
      waiting.head = list(site).push(waiting.head, point, x);
      ++waiting.count;
    }
  }
  void add(SiteNumber site, PointNumber own) { add(site, points.of_all(own), points[own]); }

  /// Takes the point at place k out of a cell; the last point takes its place.
  PointOfAll take(SiteNumber site, Index k) {
    Index& count = filled[site];
    const PointOfAll point = cells.point(site, k);
    note(site, point, -1);
    --count;
    if (k != count) cells.copy_within(site, count, k);
    return point;
  }

  /// Sorts the points that have come to a site since it had `before`, by their key(point, x), as if
  /// they had been added in that order. No key is twice.
  template <class Key>
  void sort_added(SiteNumber site, Index before, const Key& key) {
    using Value = decltype(key(PointOfAll(), static_cast<const Scalar*>(nullptr)));
    struct Added {
      Value key;
      PointOfAll point;
      std::size_t x;  ///< where its coordinates are
      bool operator<(const Added& other) const { return key < other.key; }
    };
    const std::size_t added_count =
        static_cast<std::size_t>(filled[site] - before) + static_cast<std::size_t>(waiting(site));
    std::vector<Added> added;
    std::vector<Scalar> all;
    added.reserve(added_count);
    all.reserve(added_count * cells.dimension());
    const auto append = [&](PointOfAll point, const Scalar* x) {
      all.insert(all.end(), x, x + cells.dimension());
      added.push_back({key(point, x), point, all.size() - cells.dimension()});
    };
    std::vector<Scalar> x(cells.dimension());
    for (Index k = before; k < filled[site]; ++k) {
      cells.get(site, k, x.data());
      append(cells.point(site, k), x.data());
    }
    const std::size_t placed = added.size();
    const WaitingPoints<Scalar>& list = lists_[tiles.tile_of(site)];
    for (auto node = waiting_[site].head; node != WaitingPoints<Scalar>::Node::none();
         node = list.next(node)) {
      append(list.point(node), list.coordinates(node));
    }
    // The head is the one that came last.
    std::reverse(added.begin() + static_cast<std::ptrdiff_t>(placed), added.end());
    if (std::is_sorted(added.begin(), added.end())) return;
    std::sort(added.begin(), added.end());
    while (waiting(site) > 0) {
      const Scalar* own = nullptr;
      take_waiting(site, own);
    }
    filled[site] = before;
    for (const Added& a : added) add(site, a.point, all.data() + a.x);
  }

  /// How many points of a site wait; and takes one of these.
  [[nodiscard]] Index waiting(SiteNumber site) const { return waiting_[site].count; }
  PointOfAll take_waiting(SiteNumber site, const Scalar*& x) {
    const PointOfAll point = pop_waiting(site, x);
    note(site, point, -1);
    return point;
  }

  /// Writes what there is of a site, for another rank, and reads it there. None of its points waits
  /// after the one and before the other.
  void write(ByteWriter& out, SiteNumber site) {
    out.put(filled[site]);
    cells.write(out, site, filled[site]);
    out.put(waiting(site));
    while (waiting(site) > 0) {
      const Scalar* x = nullptr;
      out.put(pop_waiting(site, x));
      out.put(std::span(x, cells.dimension()));
    }
  }
  void read(ByteReader& in, SiteNumber site) {
    filled[site] = in.get<Index>();
    cells.read(in, site, filled[site]);
    std::vector<PointOfAll> last(static_cast<std::size_t>(in.get<Index>()));
    std::vector<Scalar> x(last.size() * cells.dimension());
    for (std::size_t w = 0; w < last.size(); ++w) {
      last[w] = in.get<PointOfAll>();
      in.get(std::span(x).subspan(w * cells.dimension(), cells.dimension()));
    }
    // The first to be taken is the one that came last.
    Waiting& waiting = waiting_[site];
    for (std::size_t w = last.size(); w-- > 0;) {
      waiting.head = list(site).push(waiting.head, last[w], &x[w * cells.dimension()]);
      ++waiting.count;
    }
  }

  /// A point that came to a site, or left it.
  struct Entry {
    PointOfAll point;
    SiteNumber site;
    int change;
  };
  /// From now on a journal is kept of points that move here, until it is ended.
  void begin_journal() { journals_.resize(lists_.size()); }
  [[nodiscard]] std::vector<Entry> end_journal() {
    std::vector<Entry> all;
    for (auto& journal : std::exchange(journals_, {})) {
      all.insert(all.end(), journal.begin(), journal.end());
    }
    return all;
  }

  /// Points of a site beyond its capacity; negative where it lacks some.
  [[nodiscard]] Index surplus(SiteNumber site) const {
    return waiting(site) - (cells.size(site) - filled[site]);
  }

  Cells<Scalar>& cells;
  const OwnPoints<Scalar> points;
  const Tiling tiles;
  std::vector<Index> filled;  ///< points in each cell

 private:
  struct Waiting {
    typename WaitingPoints<Scalar>::Node head = WaitingPoints<Scalar>::Node::none();
    Index count = 0;
  };
  WaitingPoints<Scalar>& list(SiteNumber site) { return lists_[tiles.tile_of(site)]; }
  PointOfAll pop_waiting(SiteNumber site, const Scalar*& x) {
    PointOfAll point;
    Waiting& waiting = waiting_[site];
    waiting.head = list(site).pop(waiting.head, point, x);
    --waiting.count;
    return point;
  }
  void note(SiteNumber site, PointOfAll point, int change) {
    if (!journals_.empty()) journals_[tiles.tile_of(site)].push_back({point, site, change});
  }

  std::vector<Waiting> waiting_;
  std::vector<WaitingPoints<Scalar>> lists_;  ///< by tile
  std::vector<std::vector<Entry>> journals_;  ///< by tile
};

}  // namespace ccvt
