#pragma once

#include <cmath>

namespace ccvt {

/// A sum that carries its rounding error along [Neumaier 1974]: off by little more than one
/// rounding, however many terms there are.
class MassSum {
 public:
  void add(double term) {
    const double sum = sum_ + term;
    error_ += std::abs(sum_) >= std::abs(term) ? (sum_ - sum) + term : (term - sum) + sum_;
    sum_ = sum;
  }
  [[nodiscard]] double value() const { return sum_ + error_; }

 private:
  double sum_ = 0;
  double error_ = 0;
};

}  // namespace ccvt
