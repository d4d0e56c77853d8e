#pragma once

namespace ccvt {

/// A sum that loses no digits that matter: its rounding errors are summed, too [Knuth 1969; Dekker
/// 1971]. Off by little more than one rounding, however many terms there are.
class CompensatedSum {
 public:
  void add(double x) {
    const double sum = high_ + x;
    const double part = sum - high_;
    low_ += (high_ - (sum - part)) + (x - part);
    high_ = sum;
  }
  [[nodiscard]] double value() const { return high_ + low_; }

 private:
  double high_ = 0;
  double low_ = 0;
};

}  // namespace ccvt
