#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"

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
                                      const double* lower, const double* upper);

  /// Calls visit(first, last) for runs of places that together hold every site whose offset from
  /// `centre` is at most `reach` in each dimension; each place once. Others are among them.
  template <class Visit>
  void for_each_run(const double* centre, double reach, Visit visit) const;

  [[nodiscard]] std::size_t site_count() const { return site_.size(); }
  [[nodiscard]] std::size_t bin_count() const { return first_.size() - 1; }
  [[nodiscard]] std::size_t bins(std::size_t d) const { return bins_[d]; }
  /// Of a bin, along dimension d.
  [[nodiscard]] double width(std::size_t d) const { return width_[d]; }
  [[nodiscard]] double lower(std::size_t d) const { return lower_[d]; }
  /// Which site is at a place, and where it is.
  [[nodiscard]] Index site(std::size_t place) const { return site_[place]; }
  [[nodiscard]] const double* position(std::size_t place) const {
    return &position_[place * dimension_];
  }
  /// How far rounding may put a position from its bin.
  [[nodiscard]] double rounding() const { return rounding_; }

  /// A position's bin along dimension d; the nearest one of a position outside the box.
  [[nodiscard]] std::size_t bin_along(double x, std::size_t d) const {
    const double k = (x - lower_[d]) * inverse_width_[d];
    const auto last = static_cast<double>(bins_[d] - 1);
    return static_cast<std::size_t>(k < last ? (k > 0 ? k : 0) : last);
  }

 private:
  struct Range {
    std::size_t first;
    std::size_t count;
  };
  [[nodiscard]] Range range(double centre, double reach, std::size_t d) const;

  std::size_t dimension_ = 0;
  bool periodic_ = false;
  double rounding_ = 0;
  std::array<std::size_t, kMostDimensions> bins_{};
  std::array<double, kMostDimensions> lower_{};
  std::array<double, kMostDimensions> width_{};
  std::array<double, kMostDimensions> inverse_width_{};
  std::vector<std::size_t> first_;  ///< of bin b: places first_[b] to first_[b + 1] - 1
  std::vector<Index> site_;
  std::vector<double> position_;
};

/// The bins that a range of coordinates touches: all once when it reaches around the torus.
inline SiteBins::Range SiteBins::range(double centre, double reach, std::size_t d) const {
  const double room = reach + rounding_;
  if (!periodic_) {
    const std::size_t first = bin_along(centre - room, d);
    return {first, bin_along(centre + room, d) - first + 1};
  }
  const double from = std::floor((centre - room - lower_[d]) * inverse_width_[d]);
  const double to = std::floor((centre + room - lower_[d]) * inverse_width_[d]);
  const auto bins = static_cast<double>(bins_[d]);
  if (!(to - from + 1 < bins)) return {0, bins_[d]};
  const double first = from - bins * std::floor(from / bins);
  return {static_cast<std::size_t>(first), static_cast<std::size_t>(to - from) + 1};
}

template <class Visit>
void SiteBins::for_each_run(const double* centre, double reach, Visit visit) const {
  std::array<Range, kMostDimensions> ranges{Range{0, 1}, Range{0, 1}, Range{0, 1}};
  for (std::size_t d = 0; d < dimension_; ++d) ranges[d] = range(centre[d], reach, d);
  const auto around = [&](std::size_t k, std::size_t d) { return k < bins_[d] ? k : k - bins_[d]; };
  const auto [x, along] = ranges[0];
  const std::size_t stop = std::min(x + along, bins_[0]);
  const std::size_t beyond = x + along - stop;
  for (std::size_t z = 0; z < ranges[2].count; ++z) {
    const std::size_t plane = dimension_ == 3 ? around(ranges[2].first + z, 2) * bins_[1] : 0;
    for (std::size_t y = 0; y < ranges[1].count; ++y) {
      const std::size_t row = (plane + around(ranges[1].first + y, 1)) * bins_[0];
      visit(first_[row + x], first_[row + stop]);
      if (beyond > 0) visit(first_[row], first_[row + beyond]);
    }
  }
}

}  // namespace ccvt
