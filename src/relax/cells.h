#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/types.h"
#include "numbers.h"
#include "parallel/buffer.h"
#include "parallel/bytes.h"
#include "relax/point_order.h"

namespace ccvt {

/// The working tessellation: a permutation of the points grouped by site, with a copy of their
/// coordinates in that order. Cell sizes never change, so capacities hold by construction and
/// a swap allocates nothing.
///
/// The coordinates of cell s are one block of size(s) * dimension scalars, one contiguous stream
/// per dimension, so that a pair of cells is examined by streaming two blocks. They have no value,
/// and their memory no worker that it is near to, until points are put there.
template <class Scalar>
class Cells {
 public:
  Cells() = default;
  Cells(int dimension, std::span<const Index> sizes)
      : Cells(dimension, sizes, sites_below(sizes.size())) {}
  /// Of which only those of some sites, and a few others that these sites meet, are ever filled.
  /// `points`: how many are numbered, in cells or not.
  Cells(int dimension, std::span<const Index> sizes, NumberRange<SiteNumber> own,
        std::int64_t points = 0)
      : dimension_(static_cast<std::size_t>(dimension)) {
    first_.reserve(sizes.size() + 1);
    for (const Index size : sizes) first_.emplace_back(first_.back().index() + size);
    const std::size_t begin = first_[*own.begin()];
    const std::size_t used = first_[*own.end()] - begin;
    order_ = PointOrder(first_.back(), begin, used, points);
    coordinates_ =
        Buffer<Scalar>(first_.back() * dimension_, begin * dimension_, used * dimension_);
  }

  [[nodiscard]] std::size_t dimension() const { return dimension_; }
  [[nodiscard]] std::size_t site_count() const { return first_.size() - 1; }
  [[nodiscard]] NumberRange<SiteNumber> sites() const { return sites_below(site_count()); }
  [[nodiscard]] std::int64_t point_count() const { return first_.back().index(); }
  [[nodiscard]] Index size(SiteNumber site) const {
    return static_cast<Index>(first_[site + 1].index() - first_[site].index());
  }

  [[nodiscard]] std::vector<Index> sizes() const {
    std::vector<Index> sizes;
    sizes.reserve(site_count());
    for (const SiteNumber site : this->sites()) sizes.push_back(size(site));
    return sizes;
  }

  /// The points of a cell.
  [[nodiscard]] PointOrder::View points(SiteNumber site) const {
    return order_.view(first_[site], first_[site + 1] - first_[site]);
  }
  [[nodiscard]] PointOfAll point(SiteNumber site, Index k) const { return order_[place(site, k)]; }
  /// Has the number at place k of a cell fetched from memory, to be changed.
  void prefetch_point(SiteNumber site, Index k) const { order_.prefetch(place(site, k)); }

  /// The block of a cell: coordinate d of its k-th point is at [d * size(site) + k].
  [[nodiscard]] Scalar* block(SiteNumber site) {
    return coordinates_.data() + first_[site] * dimension_;
  }
  [[nodiscard]] const Scalar* block(SiteNumber site) const {
    return coordinates_.data() + first_[site] * dimension_;
  }

  /// Puts a point at place k of a cell. `coordinates` are contiguous.
  void put(SiteNumber site, Index k, PointOfAll point, const Scalar* coordinates) {
    order_.set(place(site, k), point);
    Scalar* to = block(site) + k;
    for (std::size_t d = 0; d < dimension_; ++d, to += size(site)) *to = coordinates[d];
  }

  /// Reads the coordinates at place k of a cell.
  void get(SiteNumber site, Index k, Scalar* coordinates) const {
    const Scalar* from = block(site) + k;
    for (std::size_t d = 0; d < dimension_; ++d, from += size(site)) coordinates[d] = *from;
  }

  /// Copies a cell of others, no larger, to the first places of this cell.
  void copy_points(const Cells& from, SiteNumber site) {
    const auto points = from.points(site);
    order_.copy(points, first_[site]);
    const Scalar* stream = from.block(site);
    Scalar* to = block(site);
    for (std::size_t d = 0; d < dimension_; ++d, stream += points.size(), to += size(site)) {
      std::copy_n(stream, points.size(), to);
    }
  }

  /// Writes the first points of a cell, and reads them again.
  void write(ByteWriter& out, SiteNumber site, Index count) const {
    const auto first = static_cast<std::size_t>(count);
    order_.write(out, first_[site], first);
    const Scalar* stream = block(site);
    for (std::size_t d = 0; d < dimension_; ++d, stream += size(site)) {
      out.put(std::span(stream, first));
    }
  }
  void read(ByteReader& in, SiteNumber site, Index count) {
    const auto first = static_cast<std::size_t>(count);
    order_.read(in, first_[site], first);
    Scalar* stream = block(site);
    for (std::size_t d = 0; d < dimension_; ++d, stream += size(site)) {
      in.get(std::span(stream, first));
    }
  }
  /// The same of one place, which read_place() returns.
  void write_place(ByteWriter& out, SiteNumber site, Index k) const {
    out.put(k);
    out.put(point(site, k));
    const Scalar* from = block(site) + k;
    for (std::size_t d = 0; d < dimension_; ++d, from += size(site)) out.put(*from);
  }
  Index read_place(ByteReader& in, SiteNumber site) {
    const auto k = in.get<Index>();
    order_.set(place(site, k), in.get<PointOfAll>());
    Scalar* to = block(site) + k;
    for (std::size_t d = 0; d < dimension_; ++d, to += size(site)) *to = in.get<Scalar>();
    return k;
  }

  /// The points of a cell in their order, without their coordinates, which fill() takes from all
  /// points. `end`: how many points there are.
  void save(ByteWriter& out, SiteNumber site) const {
    order_.write(out, first_[site], points(site).size());
  }
  void load(ByteReader& in, SiteNumber site, std::int64_t end) {
    order_.read(in, first_[site], points(site).size());
    for (const PointOfAll p : points(site)) {
      if (p.index() >= end) throw Damaged();
    }
  }
  /// How many bytes that takes.
  [[nodiscard]] std::size_t saved_bytes(SiteNumber site) const {
    return points(site).size() * order_.bytes();
  }
  /// `coordinates(point)`: those of a point, contiguous.
  template <class Coordinates>
  void fill(SiteNumber site, const Coordinates& coordinates) {
    for (Index k = 0; k < size(site); ++k) {
      const PointOfAll p = point(site, k);
      put(site, k, p, coordinates(p));
    }
  }

  /// Copies what is at place `from` of a cell to place `to` of it.
  void copy_within(SiteNumber site, Index from, Index to) {
    order_.set(place(site, to), point(site, from));
    Scalar* stream = block(site);
    for (std::size_t d = 0; d < dimension_; ++d, stream += size(site)) stream[to] = stream[from];
  }

  /// Puts what is at place places[k] of a cell to place k. Both vectors are scratch memory.
  void reorder(SiteNumber site, std::span<const Index> places, std::vector<PointOfAll>& points,
               std::vector<Scalar>& stream) {
    const PointOrder::View own = this->points(site);
    points.assign(own.begin(), own.end());
    stream.resize(own.size());
    for (std::size_t k = 0; k < places.size(); ++k)
      order_.set(first_[site] + k, points[static_cast<std::size_t>(places[k])]);
    Scalar* to = block(site);
    for (std::size_t d = 0; d < dimension_; ++d, to += own.size()) {
      std::copy_n(to, own.size(), stream.begin());
      for (std::size_t k = 0; k < places.size(); ++k)
        to[k] = stream[static_cast<std::size_t>(places[k])];
    }
  }

  /// Exchanges place k of cell i with place l of cell j.
  void exchange(SiteNumber i, Index k, SiteNumber j, Index l) {
    order_.exchange(place(i, k), place(j, l));
    Scalar* a = block(i) + k;
    Scalar* b = block(j) + l;
    for (std::size_t d = 0; d < dimension_; ++d, a += size(i), b += size(j)) std::swap(*a, *b);
  }

 private:
  /// In the order of the cells.
  using Place = Number<struct OfPlaces, std::int64_t>;
  [[nodiscard]] std::size_t place(SiteNumber site, Index k) const {
    return first_[site] + static_cast<std::size_t>(k);
  }

  std::size_t dimension_ = 0;
  std::vector<Place> first_{Place(0)};  ///< of each cell, and one more
  PointOrder order_;
  Buffer<Scalar> coordinates_;
};

}  // namespace ccvt
