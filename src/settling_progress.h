#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace ccvt {

/// How far a run has come in which points settle, such as the training of a codebook, from 0 to 1,
/// without ever falling. It goes through parts: levels, and what comes before them. Within one, the
/// number of points that still change their owner falls about geometrically from iteration to
/// iteration: its logarithm tells how many are left.
class SettlingProgress {
 public:
  /// The next part, and its share of all the work.
  void begin(double share) {
    before_ = std::min(1.0, before_ + share_);
    share_ = std::min(share, 1 - before_);
    most_ = 0;
  }

  /// An iteration moved so many points.
  double moved(std::int64_t points) {
    const double size = std::log1p(static_cast<double>(points));
    most_ = std::max(most_, size);
    return reach(most_ > 0 ? 1 - size / most_ : 1);
  }

  /// So much of the part is done.
  double reach(double share) {
    value_ = std::max(value_, before_ + share_ * std::clamp(share, 0.0, 1.0));
    return value_;
  }

 private:
  double before_ = 0;
  double share_ = 0;
  double most_ = 0;
  double value_ = 0;
};

}  // namespace ccvt
