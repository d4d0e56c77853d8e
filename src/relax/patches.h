#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "parallel/bytes.h"
#include "relax/cells.h"

namespace ccvt {

/// Large cells, divided into patches: consecutive points that lie close together, with a box around
/// them. What concerns the border of a cell looks at the patches near it, and leaves the others
/// alone. Also what is known of the points that such a cell has exchanged.
///
/// A cell is divided when it has been looked at often enough for that to pay, and anew when many of
/// its points have been replaced. Only the order of its points changes. Cells may be used at the
/// same time by different workers.
template <class Scalar>
class Patches {
 public:
  /// `sizes`: how many points each cell has.
  Patches(int dimension, std::span<const Index> sizes)
      : dimension_(static_cast<std::size_t>(dimension)), exchanged_(sizes.size()) {
    Index last = 0;  // most are alike
    const auto is_divided = [&](Index size) {
      return size != std::exchange(last, size) && divides(size);
    };
    if (std::any_of(sizes.begin(), sizes.end(), is_divided)) cells_.resize(sizes.size());
  }

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
  [[nodiscard]] bool has(SiteNumber site) const {
    return !cells_.empty() && !cells_[site].low.empty();
  }
  /// Of a divided cell: the points of a patch, but for the last one; and how many patches.
  [[nodiscard]] Index size(SiteNumber site) const { return cells_[site].size; }
  [[nodiscard]] std::size_t count(SiteNumber site) const {
    return cells_[site].low.size() / dimension_ - 1;
  }
  /// The boxes' lower and upper ends, a stream for each dimension; after those of the patches that
  /// of the cell.
  [[nodiscard]] std::span<const Scalar> low(SiteNumber site) const { return cells_[site].low; }
  [[nodiscard]] std::span<const Scalar> high(SiteNumber site) const { return cells_[site].high; }

  /// Whether any is ever divided: where not, nothing is known but exchanged(), and nothing else may
  /// be asked but has().
  [[nodiscard]] bool any() const { return !cells_.empty(); }
  /// Whether a cell of so many points is ever divided. What is known of others does not matter.
  [[nodiscard]] bool divides(Index points) const { return ends(points) > 0; }

  /// What is known may be wrong.
  void forget() noexcept {
    for (Cell& cell : cells_) {
      cell.low.clear();
      cell.high.clear();
      cell.changes.forget();
      cell.sums.exchanged = Sums::kUnknown;
    }
  }

  /// What is known of a cell of so many points, for another rank or a file: in as many bytes for
  /// all of that size, and in none for those that are never divided.
  void save(ByteWriter& out, SiteNumber site, Index points) const;
  void load(ByteReader& in, SiteNumber site, Index points);
  [[nodiscard]] std::size_t bytes(Index points) const {
    if (!divides(points)) return 0;
    return 4 * sizeof(Index) + Sums::bytes(dimension_) + 2 * ends(points) * sizeof(Scalar);
  }

  /// Rises whenever another point has come to a cell, or may have.
  [[nodiscard]] std::uint32_t exchanged(SiteNumber site) const { return exchanged_[site]; }

  /// Says that another point has come to a place of a cell, and which one has left it.
  void replace(SiteNumber site, Index place, const Scalar* coordinates, const Scalar* left);

  /// What exchanges have changed of a divided cell since all of its points were summed up: see
  /// update_by_sums().
  struct Sums {
    static constexpr Index kUnknown = -1;
    Index exchanged = kUnknown;  ///< points
    Index updates = 0;           ///< of the site
    double moved = 0;            ///< how far the site has gone, at most
    double first_energy = 0;
    double energy = 0;           ///< of the points as they are now, around `centre`
    std::vector<double> centre;  ///< where the site was then
    std::vector<double> shift;   ///< of the sum of the points' coordinates
    /// Of all but `exchanged`.
    static std::size_t bytes(std::size_t dimension) {
      return sizeof(Index) + (3 + 2 * dimension) * sizeof(double);
    }
  };
  [[nodiscard]] Sums& sums(SiteNumber site) { return cells_[site].sums; }

  /// The places of a divided cell that other points have come to, in order, since `version` last
  /// rose; before that any may have changed.
  struct Changes {
    std::uint32_t version = 0;
    std::vector<Index> places;
    std::size_t room = 0;      ///< for so many
    std::vector<Scalar> come;  ///< their coordinates, a stream of `room` for each dimension
    std::vector<Scalar> left;  ///< those of the points that were there
    std::vector<Scalar> box;   ///< around those that came: for each dimension, both ends
    void forget() {
      ++version;
      places.clear();
      box.clear();
    }
    void add(Index place, const Scalar* comes, const Scalar* leaves, std::size_t dimension);
  };
  [[nodiscard]] const Changes& changes(SiteNumber site) const { return cells_[site].changes; }
  /// Has those after the first ones fetched from memory.
  void prefetch_changes(SiteNumber site, std::size_t known) const {
    const Changes& changes = cells_[site].changes;
    const std::size_t next = std::min(known, changes.places.size());
    for (const auto* streams : {&changes.come, &changes.left}) {
      for (std::size_t d = 0; d < dimension_; ++d) {
        __builtin_prefetch(streams->data() + d * changes.room + next);
      }
    }
  }

 private:
  struct Cell {
    std::vector<Scalar> low;
    std::vector<Scalar> high;
    Index size = 0;  ///< of a patch
    Index looks = 0;
    Index replaced = 0;
    Changes changes;
    Sums sums;
  };
  [[nodiscard]] Index patch_size(Index points) const;
  [[nodiscard]] std::size_t ends(Index points) const;
  void sort(Cells<Scalar>& cells, SiteNumber site, Scratch& scratch) const;

  std::size_t dimension_;
  std::vector<Cell> cells_;               ///< none where none is ever divided
  std::vector<std::uint32_t> exchanged_;  ///< of each cell
};

extern template class Patches<float>;
extern template class Patches<double>;

}  // namespace ccvt
