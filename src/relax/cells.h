#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/buffer.h"

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
      : dimension_(dimension), offset_(sizes.size() + 1, 0) {
    for (std::size_t s = 0; s < sizes.size(); ++s) offset_[s + 1] = offset_[s] + sizes[s];
    order_.reset(at(offset_.back()));
    coordinates_.reset(order_.size() * at(dimension));
  }

  [[nodiscard]] int dimension() const { return dimension_; }
  [[nodiscard]] Index site_count() const { return static_cast<Index>(offset_.size()) - 1; }
  [[nodiscard]] Index point_count() const { return static_cast<Index>(order_.size()); }
  [[nodiscard]] Index size(Index site) const { return offset_[at(site) + 1] - offset_[at(site)]; }

  [[nodiscard]] std::vector<Index> sizes() const {
    std::vector<Index> sizes(static_cast<std::size_t>(site_count()));
    for (std::size_t s = 0; s < sizes.size(); ++s) sizes[s] = size(static_cast<Index>(s));
    return sizes;
  }

  /// The points of a cell, by number.
  [[nodiscard]] Index* points(Index site) { return order_.data() + offset_[at(site)]; }
  [[nodiscard]] const Index* points(Index site) const { return order_.data() + offset_[at(site)]; }

  /// The block of a cell: coordinate d of its k-th point is at [d * size(site) + k].
  [[nodiscard]] Scalar* block(Index site) {
    return coordinates_.data() + at(offset_[at(site)]) * at(dimension_);
  }
  [[nodiscard]] const Scalar* block(Index site) const {
    return coordinates_.data() + at(offset_[at(site)]) * at(dimension_);
  }

  /// Puts a point at place k of a cell. `coordinates` are contiguous.
  void put(Index site, Index k, Index point, const Scalar* coordinates) {
    points(site)[k] = point;
    Scalar* to = block(site) + k;
    for (int d = 0; d < dimension_; ++d, to += size(site)) *to = coordinates[d];
  }

  /// Reads the coordinates at place k of a cell.
  void get(Index site, Index k, Scalar* coordinates) const {
    const Scalar* from = block(site) + k;
    for (int d = 0; d < dimension_; ++d, from += size(site)) coordinates[d] = *from;
  }

  /// Copies a cell of others, no larger, to the first places of this cell.
  void copy_points(const Cells& from, Index site) {
    const auto count = at(from.size(site));
    std::copy_n(from.points(site), count, points(site));
    const Scalar* stream = from.block(site);
    Scalar* to = block(site);
    for (int d = 0; d < dimension_; ++d, stream += count, to += size(site)) {
      std::copy_n(stream, count, to);
    }
  }

  /// Copies what is at place `from` of a cell to place `to` of it.
  void copy_within(Index site, Index from, Index to) {
    points(site)[to] = points(site)[from];
    Scalar* stream = block(site);
    for (int d = 0; d < dimension_; ++d, stream += size(site)) stream[to] = stream[from];
  }

  /// Exchanges place k of cell i with place l of cell j.
  void exchange(Index i, Index k, Index j, Index l) {
    std::swap(points(i)[k], points(j)[l]);
    Scalar* a = block(i) + k;
    Scalar* b = block(j) + l;
    for (int d = 0; d < dimension_; ++d, a += size(i), b += size(j)) std::swap(*a, *b);
  }

 private:
  static std::size_t at(Index i) { return static_cast<std::size_t>(i); }

  int dimension_ = 0;
  std::vector<Index> offset_;
  Buffer<Index> order_;
  Buffer<Scalar> coordinates_;
};

}  // namespace ccvt
