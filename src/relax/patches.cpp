#include "relax/patches.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "kernels/streams.h"

namespace ccvt {
namespace {

/// Dividing takes about as long as looking at all of a cell so many times.
constexpr Index kLooks = 32;
/// Points of a patch, of the cube root of its cell's: to bound the keys of a patch takes as long as
/// to look at a dozen points, and the patches near a border of a cell in the plane are about as
/// many as the root of all.
constexpr double kSizeOfRoot = 14;
constexpr Index kSizeStep = 16;  // whole vectors
/// Patches along each dimension that a cell must have, else most of them are near some border.
constexpr double kLeastAlong = 4;
/// Of its points: when so many have been replaced, a cell is divided anew.
constexpr Index kReplacedShare = 4;
/// Of its points: so many changes are kept in mind.
constexpr std::size_t kChangesShare = 16;
/// Bins of a patch, along the last dimension: within a bin points are in no order.
constexpr double kBinsOfPatch = 8;

/// A grid over a cell, as its points are spread. Consecutive bins are neighbours: every other row
/// runs backwards.
template <class Scalar>
class Grid {
 public:
  Grid(const Scalar* block, Index count, std::size_t dimension, double patches) {
    const double along = std::pow(patches, 1.0 / static_cast<double>(dimension));
    for (std::size_t d = 0; d < dimension; ++d, block += count) {
      const bool last = d + 1 == dimension;
      const auto [low, high] = kernels::range(block, count);
      const double bins = std::max(1.0, std::floor(along * (last ? kBinsOfPatch : 1)));
      const double width = static_cast<double>(high) - static_cast<double>(low);
      // Where a cell is so narrow that this is infinite, it is not divided along.
      const auto per_width = static_cast<Scalar>(width > 0 ? bins / width : 0);
      axes_.push_back({low, std::isfinite(per_width) ? per_width : Scalar{0},
                       static_cast<std::uint32_t>(bins)});
    }
  }

  [[nodiscard]] std::size_t bin_count() const {
    std::size_t bins = 1;
    for (const Axis& axis : axes_) bins *= axis.bins;
    return bins;
  }
  /// Of a row so far, the row that coordinate x along dimension d leads to.
  [[nodiscard]] std::uint32_t next(std::uint32_t row, Scalar x, std::size_t d) const {
    const Axis& axis = axes_[d];
    const auto last = static_cast<Scalar>(axis.bins - 1);
    const auto at = static_cast<std::uint32_t>(std::min((x - axis.low) * axis.per_width, last));
    return row * axis.bins + (row % 2 == 0 ? at : axis.bins - 1 - at);
  }

 private:
  struct Axis {
    Scalar low;
    Scalar per_width;
    std::uint32_t bins;
  };
  std::vector<Axis> axes_;
};

}  // namespace

/// Of a cell of so many points; 0 where it is not worth dividing.
template <class Scalar>
Index Patches<Scalar>::patch_size(Index points) const {
  const auto size = static_cast<Index>(kSizeOfRoot * std::cbrt(points)) / kSizeStep * kSizeStep;
  const bool pays = points >= size * std::pow(kLeastAlong, static_cast<double>(dimension_));
  return pays ? size : 0;
}

/// Of all boxes of a divided cell: how many lower ends there are.
template <class Scalar>
std::size_t Patches<Scalar>::ends(Index points) const {
  const Index size = patch_size(points);
  return size == 0 ? 0 : (static_cast<std::size_t>((points + size - 1) / size) + 1) * dimension_;
}

template <class Scalar>
bool Patches<Scalar>::look(Cells<Scalar>& cells, SiteNumber site, Scratch& scratch) {
  if (!any()) return false;
  Cell& cell = cells_[site];
  const Index points = cells.size(site);
  if (++cell.looks < kLooks) return false;
  cell.looks = 0;
  if (has(site) && cell.replaced <= points / kReplacedShare) return false;
  const Index size = patch_size(points);
  if (size == 0) return false;
  cell.low.resize(ends(points));
  cell.high.resize(cell.low.size());
  cell.size = size;
  const std::size_t count = this->count(site);
  sort(cells, site, scratch);
  cell.changes.forget();
  cell.replaced = 0;
  const Scalar* stream = cells.block(site);
  Scalar* low = cell.low.data();
  Scalar* high = cell.high.data();
  for (std::size_t d = 0; d < dimension_; ++d, stream += points) {
    for (std::size_t k = 0; k < count; ++k) {
      const Index first = static_cast<Index>(k) * size;
      const auto box = kernels::range(stream + first, std::min(size, points - first));
      low[k] = box.low;
      high[k] = box.high;
    }
    low[count] = *std::min_element(low, low + count);
    high[count] = *std::max_element(high, high + count);
    low += count + 1;
    high += count + 1;
  }
  return true;
}

/// Sorts the points of a cell by the bins of a grid.
template <class Scalar>
void Patches<Scalar>::sort(Cells<Scalar>& cells, SiteNumber site, Scratch& scratch) const {
  const std::size_t count = cells.points(site).size();
  const Grid<Scalar> grid(cells.block(site), cells.size(site), dimension_,
                          static_cast<double>(this->count(site)));
  scratch.bin.assign(count, 0);
  const Scalar* stream = cells.block(site);
  for (std::size_t d = 0; d < dimension_; ++d, stream += count) {
    for (std::size_t k = 0; k < count; ++k) {
      scratch.bin[k] = grid.next(scratch.bin[k], stream[k], d);
    }
  }
  scratch.first.assign(grid.bin_count() + 1, 0);
  for (const std::uint32_t bin : scratch.bin) ++scratch.first[bin + 1];
  std::partial_sum(scratch.first.begin(), scratch.first.end(), scratch.first.begin());
  scratch.order.resize(count);
  for (std::size_t k = 0; k < count; ++k) {
    scratch.order[scratch.first[scratch.bin[k]]++] = static_cast<Index>(k);
  }
  cells.reorder(site, scratch.order, scratch.points, scratch.stream);
}

template <class Scalar>
void Patches<Scalar>::Changes::add(Index place, const Scalar* comes, const Scalar* leaves,
                                   std::size_t dimension) {
  if (places.size() == room) forget();
  const std::size_t at = places.size();
  places.push_back(place);
  if (box.empty()) {
    for (std::size_t d = 0; d < dimension; ++d) box.insert(box.end(), {comes[d], comes[d]});
  }
  for (std::size_t d = 0; d < dimension; ++d) {
    come[d * room + at] = comes[d];
    left[d * room + at] = leaves[d];
    box[2 * d] = std::min(box[2 * d], comes[d]);
    box[2 * d + 1] = std::max(box[2 * d + 1], comes[d]);
  }
}

template <class Scalar>
void Patches<Scalar>::replace(SiteNumber site, Index place, const Scalar* coordinates,
                              const Scalar* left) {
  ++exchanged_[site];
  if (!has(site)) return;
  Cell& cell = cells_[site];
  ++cell.replaced;
  const std::size_t patches = count(site);
  Changes& changes = cell.changes;
  if (changes.room == 0) {
    const std::size_t room = patches * static_cast<std::size_t>(cell.size) / kChangesShare;
    changes.come.resize(dimension_ * room);
    changes.left.resize(dimension_ * room);
    changes.room = room;  // when there is room in both
  }
  changes.add(place, coordinates, left, dimension_);
  Sums& sums = cell.sums;
  if (sums.exchanged != Sums::kUnknown) {
    ++sums.exchanged;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double come_from = coordinates[d] - sums.centre[d];
      const double gone_from = left[d] - sums.centre[d];
      const double by = come_from - gone_from;
      sums.shift[d] += by;
      sums.energy += by * (come_from + gone_from);
    }
  }
  const auto patch = static_cast<std::size_t>(place / cell.size);
  for (std::size_t d = 0; d < dimension_; ++d) {
    for (const std::size_t k : {d * (patches + 1) + patch, d * (patches + 1) + patches}) {
      cell.low[k] = std::min(cell.low[k], coordinates[d]);
      cell.high[k] = std::max(cell.high[k], coordinates[d]);
    }
  }
}

template <class Scalar>
void Patches<Scalar>::save(ByteWriter& out, SiteNumber site, Index points) const {
  if (!divides(points)) return;
  const Cell& cell = cells_[site];
  out.put(cell.looks);
  out.put(cell.replaced);
  const Sums& sums = cell.sums;
  out.put(sums.exchanged);
  if (sums.exchanged == Sums::kUnknown) {
    out.put_nothing(Sums::bytes(dimension_));
  } else {
    out.put(sums.updates);
    out.put(sums.moved);
    out.put(sums.first_energy);
    out.put(sums.energy);
    out.put(std::span<const double>(sums.centre));
    out.put(std::span<const double>(sums.shift));
  }
  out.put(Index{has(site)});
  out.put(std::span<const Scalar>(cell.low));
  out.put(std::span<const Scalar>(cell.high));
  if (!has(site)) out.put_nothing(2 * ends(points) * sizeof(Scalar));
}

template <class Scalar>
void Patches<Scalar>::load(ByteReader& in, SiteNumber site, Index points) {
  ++exchanged_[site];
  if (!divides(points)) return;
  Cell& cell = cells_[site];
  cell.changes.forget();
  cell.looks = in.get<Index>();
  cell.replaced = in.get<Index>();
  Sums& sums = cell.sums;
  sums.exchanged = in.get<Index>();
  if (sums.exchanged == Sums::kUnknown) {
    in.skip(Sums::bytes(dimension_));
  } else {
    sums.updates = in.get<Index>();
    sums.moved = in.get<double>();
    sums.first_energy = in.get<double>();
    sums.energy = in.get<double>();
    sums.centre.resize(dimension_);
    sums.shift.resize(dimension_);
    in.get(std::span(sums.centre));
    in.get(std::span(sums.shift));
  }
  if (in.get<Index>() == 0) {
    cell.low.clear();
    cell.high.clear();
    return in.skip(2 * ends(points) * sizeof(Scalar));
  }
  cell.size = patch_size(points);
  cell.low.resize(ends(points));
  cell.high.resize(ends(points));
  in.get(std::span(cell.low));
  in.get(std::span(cell.high));
}

template class Patches<float>;
template class Patches<double>;

}  // namespace ccvt
