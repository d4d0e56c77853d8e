#pragma once

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "parallel/loops.h"

namespace ccvt {

/// Sites in two or three dimensions, sorted into the bins of a grid of about one bin a site.
///
/// For sites that spread evenly, and queries not much wider than a bin, faster than a tree.
class SiteBins {
 public:
  static constexpr std::size_t kMostDimensions = 3;

  /// `positions`: #dimensions by n, copied. `lower`, `upper`: a box around them, on a torus its
  /// box; sites outside it count to the nearest bin. Nothing when bins do not pay: in other
  /// dimensions, in a box that is flat, or when the sites crowd in few of the bins.
  static std::optional<SiteBins> sort(const Metric& metric, std::span<const double> positions,
                                      const double* lower, const double* upper,
                                      const Arena& arena = Arena(1));

  /// Calls visit(place, offset) for every site whose offset from `centre`, in the box, is at most
  /// `reach` in each dimension, each once, and for others near them. Offsets are an array of
  /// `Dimension`, the bins' own; on a torus, of the images nearest to `centre` for those within
  /// reach.
  template <std::size_t Dimension, class Visit>
  void for_each_offset(const double* centre, double reach, Visit visit) const;

  [[nodiscard]] std::size_t dimension() const { return dimension_; }
  [[nodiscard]] std::span<const Index> sites_in(std::size_t bin) const { return sites_[bin]; }
  [[nodiscard]] std::size_t site_count() const { return sites_.items.size(); }
  [[nodiscard]] std::size_t bin_count() const { return sites_.count(); }
  [[nodiscard]] std::size_t bins(std::size_t d) const { return static_cast<std::size_t>(bins_[d]); }
  /// Of a bin, along dimension d.
  [[nodiscard]] double width(std::size_t d) const { return width_[d]; }
  [[nodiscard]] double lower(std::size_t d) const { return lower_[d]; }
  /// Which site is at a place, and where it is.
  [[nodiscard]] Index site(std::size_t place) const { return sites_.items[place]; }
  [[nodiscard]] const double* position(std::size_t place) const {
    return &position_[place * dimension_];
  }
  /// How far rounding may put a position from its bin.
  [[nodiscard]] double rounding() const { return rounding_; }

  /// A position's bin along dimension d; the nearest one of a position outside the box.
  [[nodiscard]] std::size_t bin_along(double x, std::size_t d) const {
    return static_cast<std::size_t>(along(x, d));
  }

 private:
  /// Bins along a dimension; on a torus, of its images too: -1 is the last bin, one turn before.
  struct Range {
    std::ptrdiff_t first;
    std::ptrdiff_t count;
  };
  /// In bins from the lower face; from 0 to the last bin.
  [[nodiscard]] double along(double x, std::size_t d) const {
    const double k = (x - lower_[d]) * inverse_width_[d];
    return k < last_[d] ? (k > 0 ? k : 0) : last_[d];
  }
  [[nodiscard]] Range range(double centre, double reach, std::size_t d) const;

  std::size_t dimension_ = 0;
  bool periodic_ = false;
  double rounding_ = 0;
  std::array<std::ptrdiff_t, kMostDimensions> bins_{};
  std::array<double, kMostDimensions> last_{};  ///< bins less one
  std::array<double, kMostDimensions> lower_{};
  std::array<double, kMostDimensions> extent_{};  ///< of the torus; infinite in Euclidean space
  std::array<double, kMostDimensions> width_{};
  std::array<double, kMostDimensions> inverse_width_{};
  Groups<Index> sites_;      ///< by bin; places are in its items
  Buffer<double> position_;  ///< by place
};

/// The bins that a range of coordinates touches: all once when it reaches around the torus.
inline SiteBins::Range SiteBins::range(double centre, double reach, std::size_t d) const {
  const double room = reach + rounding_;
  double from = 0;
  double to = 0;
  if (periodic_) {
    from = std::floor((centre - room - lower_[d]) * inverse_width_[d]);
    to = std::floor((centre + room - lower_[d]) * inverse_width_[d]);
    if (!(to - from < last_[d])) return {0, bins_[d]};
  } else {
    from = along(centre - room, d);
    to = along(centre + room, d);
  }
  const auto first = static_cast<std::ptrdiff_t>(from);
  return {first, static_cast<std::ptrdiff_t>(to) - first + 1};
}

template <std::size_t Dimension, class Visit>
void SiteBins::for_each_offset(const double* centre, double reach, Visit visit) const {
  assert(Dimension == dimension_);
  std::array<Range, kMostDimensions> ranges{Range{0, 1}, Range{0, 1}, Range{0, 1}};
  // Whether the nearest image of a site within reach is the one in the range of bins.
  bool narrow = true;
  for (std::size_t d = 0; d < Dimension; ++d) {
    ranges[d] = range(centre[d], reach, d);
    narrow = narrow && (!periodic_ || (ranges[d].count < bins_[d] &&
                                       2 * (reach + rounding_ + width_[d]) < extent_[d]));
  }
  std::array<double, kMostDimensions> turn{};
  const auto visit_run = [&](std::size_t first, std::size_t last) {
    std::array<double, Dimension> offset;
    for (std::size_t place = first; place < last; ++place) {
      const double* at = position(place);
      for (std::size_t d = 0; d < Dimension; ++d) {
        const double difference = at[d] - centre[d];
        offset[d] = narrow ? difference + turn[d] : shortest_difference(difference, extent_[d]);
      }
      visit(place, offset);
    }
  };
  /// The bin within the box, having set the turn that leads to its image.
  const auto into_box = [&](std::ptrdiff_t bin, std::size_t d) {
    const std::ptrdiff_t bins = bins_[d];
    turn[d] = bin < 0 ? -extent_[d] : bin >= bins ? extent_[d] : 0;
    return bin < 0 ? bin + bins : bin >= bins ? bin - bins : bin;
  };
  const std::size_t* first = sites_.first.data();
  const std::ptrdiff_t wide = ranges[0].count;
  for (std::ptrdiff_t z = 0; z < ranges[2].count; ++z) {
    const std::ptrdiff_t plane = Dimension == 3 ? into_box(ranges[2].first + z, 2) * bins_[1] : 0;
    for (std::ptrdiff_t y = 0; y < ranges[1].count; ++y) {
      const std::ptrdiff_t row = (plane + into_box(ranges[1].first + y, 1)) * bins_[0];
      const std::ptrdiff_t x = into_box(ranges[0].first, 0);
      const std::ptrdiff_t stop = std::min(x + wide, bins_[0]);
      visit_run(first[row + x], first[row + stop]);
      const std::ptrdiff_t beyond = x + wide - stop;
      if (beyond == 0) continue;
      into_box(ranges[0].first + wide - 1, 0);
      visit_run(first[row], first[row + beyond]);
    }
  }
}

}  // namespace ccvt
