#pragma once

#include <vector>

#include "ccvt/metrics.h"
#include "parallel/arena.h"

namespace ccvt {

/// Every frequency k of the box with |k_d| <= half[d], the first dimension fastest, in 1 to 3
/// dimensions; the layout of Spectrum::power.
class FrequencyGrid {
 public:
  explicit FrequencyGrid(std::vector<int> half) : half_(std::move(half)) {}

  [[nodiscard]] const std::vector<int>& half() const { return half_; }
  [[nodiscard]] std::size_t width(std::size_t d) const {
    return 2 * static_cast<std::size_t>(half_[d]) + 1;
  }
  [[nodiscard]] std::size_t size() const {
    std::size_t size = 1;
    for (std::size_t d = 0; d < half_.size(); ++d) size *= width(d);
    return size;
  }

  /// What add_power() needs, the power included, in bytes; `half` may be too large for a grid.
  [[nodiscard]] static double bytes(const Eigen::ArrayXd& half);

  /// Adds |sum over points of exp(-2 pi i f.p)|^2 at every frequency but 0.
  void add_power(const PointSet& set, const Arena& arena, std::vector<double>& power) const;

 private:
  std::vector<int> half_;
};

}  // namespace ccvt
