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
  explicit ScalarBox(const Box& box) {
    constexpr Scalar infinity = std::numeric_limits<Scalar>::infinity();
    for (Eigen::Index d = 0; d < box.lower.size(); ++d) {
      auto first = static_cast<Scalar>(box.lower[d]);
      if (static_cast<double>(first) < box.lower[d]) first = std::nextafter(first, infinity);
      auto last = static_cast<Scalar>(box.upper[d]);
      if (static_cast<double>(last) >= box.upper[d]) last = std::nextafter(last, -infinity);
      first_.push_back(first);
      last_.push_back(last);
    }
  }

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
