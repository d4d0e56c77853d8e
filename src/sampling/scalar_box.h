#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "ccvt/domain.h"

namespace ccvt {

/// Rounds coordinates to Scalar such that they stay in [lower, upper) of a box. Both corners must
/// be within the range of Scalar.
template <class Scalar>
class ScalarBox {
 public:
  explicit ScalarBox(const Box& box)
      : first_(box.lower.begin(), box.lower.end()), last_(box.upper.begin(), box.upper.end()) {
    constexpr Scalar infinity = std::numeric_limits<Scalar>::infinity();
    for (std::size_t d = 0; d < first_.size(); ++d) {
      if (first_[d] < box.lower.data()[d]) first_[d] = std::nextafter(first_[d], infinity);
      if (last_[d] >= box.upper.data()[d]) last_[d] = std::nextafter(last_[d], -infinity);
    }
  }

  [[nodiscard]] std::size_t dimension() const { return first_.size(); }

  /// Whether no Scalar lies in [lower, upper) of dimension d.
  [[nodiscard]] bool empty(std::size_t d) const { return first_[d] > last_[d]; }

  [[nodiscard]] Scalar round(std::size_t d, double x) const {
    return std::clamp(static_cast<Scalar>(x), first_[d], last_[d]);
  }

 private:
  std::vector<Scalar> first_;  // the least and the greatest Scalar in the box
  std::vector<Scalar> last_;
};

}  // namespace ccvt
