#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "parallel/bytes.h"
#include "relax/cells.h"

namespace ccvt {

/// Large cells, divided into patches: consecutive points that lie close together, with a box around
/// them. What concerns the border of a cell looks at the patches near it, and leaves the others
/// alone.
///
/// A cell is divided when it has been looked at often enough for that to pay, and anew when many of
/// its points have been replaced. Only the order of its points changes. Cells may be used at the
/// same time by different workers.
template <class Scalar>
class Patches {
 public:
  Patches(int dimension, std::size_t sites)
      : dimension_(static_cast<std::size_t>(dimension)), cells_(sites) {}

  /// What dividing a cell needs. One per worker.
  struct Scratch {
    std::vector<std::uint32_t> bin;
    std::vector<std::uint32_t> first;
    std::vector<Index> order;
    std::vector<Scalar> stream;
    std::vector<PointOfAll> points;
  };
  /// Says that a cell will be looked at: divides it when it is time to. O(size) then. Returns
  /// whether it did, and its points are in another order.
  bool look(Cells<Scalar>& cells, SiteNumber site, Scratch& scratch);

  /// Whether the cell is divided.
  [[nodiscard]] bool has(SiteNumber site) const { return !cells_[site].low.empty(); }
  /// Of a divided cell: the points of a patch, but for the last one; and how many patches.
  [[nodiscard]] Index size(SiteNumber site) const { return cells_[site].size; }
  [[nodiscard]] std::size_t count(SiteNumber site) const {
    return cells_[site].low.size() / dimension_ - 1;
  }
  /// The boxes' lower and upper ends, a stream for each dimension; after those of the patches that
  /// of the cell.
  [[nodiscard]] std::span<const Scalar> low(SiteNumber site) const { return cells_[site].low; }
  [[nodiscard]] std::span<const Scalar> high(SiteNumber site) const { return cells_[site].high; }

  /// Whether a cell of so many points is ever divided. What is known of others does not matter.
  [[nodiscard]] bool divides(Index points) const { return ends(points) > 0; }

  /// What is known of a cell of so many points, for another rank or a file: in as many bytes for
  /// all of that size, and in none for those that are never divided.
  void save(ByteWriter& out, SiteNumber site, Index points) const;
  void load(ByteReader& in, SiteNumber site, Index points);
  [[nodiscard]] std::size_t bytes(Index points) const {
    return divides(points) ? 3 * sizeof(Index) + 2 * ends(points) * sizeof(Scalar) : 0;
  }

  /// Says that another point has come to a place of a cell.
  void replace(SiteNumber site, Index place, const Scalar* coordinates);

 private:
  struct Cell {
    std::vector<Scalar> low;
    std::vector<Scalar> high;
    Index size = 0;  ///< of a patch
    Index looks = 0;
    Index replaced = 0;
  };
  [[nodiscard]] Index patch_size(Index points) const;
  [[nodiscard]] std::size_t ends(Index points) const;
  void sort(Cells<Scalar>& cells, SiteNumber site, Scratch& scratch) const;

  std::size_t dimension_;
  std::vector<Cell> cells_;
};

extern template class Patches<float>;
extern template class Patches<double>;

}  // namespace ccvt
