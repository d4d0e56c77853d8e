#pragma once

#include <span>
#include <vector>

#include "ccvt/export.h"
#include "ccvt/types.h"

namespace ccvt {

/// A partition of the points into cells, one per site: a permutation of the points grouped by
/// owner. Point numbers ascend within a cell.
class CCVT_EXPORT Tessellation {
 public:
  /// From the owner of every point. O(m + n). Throws InvalidInput when an owner is not in
  /// 0..sites-1.
  Tessellation(std::span<const Index> owners, Index sites);

  [[nodiscard]] Index point_count() const { return static_cast<Index>(order_.size()); }
  [[nodiscard]] Index site_count() const { return static_cast<Index>(offset_.size()) - 1; }
  /// The points owned by `site`.
  [[nodiscard]] std::span<const Index> cell(Index site) const {
    const auto s = static_cast<std::size_t>(site);
    return std::span(order_).subspan(static_cast<std::size_t>(offset_[s]),
                                     static_cast<std::size_t>(offset_[s + 1] - offset_[s]));
  }
  /// All points, grouped by site.
  [[nodiscard]] std::span<const Index> order() const { return order_; }
  /// Cell s is order()[offset()[s] .. offset()[s + 1]); n + 1 entries.
  [[nodiscard]] std::span<const Index> offset() const { return offset_; }

 private:
  std::vector<Index> order_;
  std::vector<Index> offset_;
};

}  // namespace ccvt
