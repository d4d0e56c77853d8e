#pragma once

#include <cstddef>

#include "ccvt/thin.h"
#include "ccvt/types.h"
#include "random.h"

namespace ccvt::test {

/// Two sheets .02 apart that face away from each other.
struct Sheets {
  Points<double> points;
  Points<double> normals;

  /// One in `lower` points lies on the lower one.
  explicit Sheets(Index count, Index lower = 2) : points(3, count), normals(3, count) {
    Random random(5);
    for (Index p = 0; p < count; ++p) {
      points.col(p) << random.uniform(), random.uniform(), p % lower == 0 ? 0 : 0.02;
      normals.col(p) << 0, 0, p % lower == 0 ? -3 : 0.5;
    }
  }
  [[nodiscard]] Index across(const Thinning& thinning) const {
    Index count = 0;
    for (std::size_t p = 0; p < thinning.owners.size(); ++p) {
      const Index chosen = thinning.chosen[static_cast<std::size_t>(thinning.owners[p])];
      if (points(2, static_cast<Index>(p)) != points(2, chosen)) ++count;
    }
    return count;
  }
};

}  // namespace ccvt::test
