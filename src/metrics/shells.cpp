#include "metrics/shells.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ccvt {

namespace {

constexpr double kMostQuanta = 65536;

}  // namespace

FrequencyShells::FrequencyShells(Eigen::VectorXd steps, double highest)
    : steps_(std::move(steps)), quantum_(highest * highest / kMostQuanta) {
  const double step = steps_[0];
  cube_ = ((steps_.array() - step).abs() <= 1e-9 * step).all() &&
          highest * highest / (step * step) <= kMostQuanta;
  if (cube_) quantum_ = step * step;
  most_ = static_cast<std::size_t>(highest * highest / quantum_ * (1 + 1e-12));
  ways_.assign(1, Row(most_ + 1, 0.0));
  ways_[0][0] = 1;
  for (int d = 0; d < steps_.size(); ++d) {
    Row next = ways_.back();  // k = 0
    for (int k = 1; quanta_of(d, k) <= most_; ++k) {
      const std::size_t q = quanta_of(d, k);
      for (std::size_t s = q; s <= most_; ++s) next[s] += 2 * ways_.back()[s - q];
    }
    ways_.push_back(std::move(next));
  }
  ways_.back()[0] -= 1;  // k = 0 is no frequency
}

std::size_t FrequencyShells::quanta_of(int d, int k) const {
  if (cube_) return static_cast<std::size_t>(k) * static_cast<std::size_t>(k);
  const double f = k * steps_[d];
  return static_cast<std::size_t>(f * f / quantum_ + 0.5);
}

/// The least number of quanta that is not below a frequency.
std::size_t FrequencyShells::first_at(double frequency) const {
  const double quanta = frequency * frequency / quantum_;
  return std::min(most_ + 1, static_cast<std::size_t>(std::ceil(quanta * (1 - 1e-12))));
}

double FrequencyShells::count(double lower, double upper) const {
  double sum = 0;
  for (std::size_t s = first_at(lower); s < first_at(upper); ++s) sum += ways_.back()[s];
  return sum / 2;
}

Eigen::VectorXi FrequencyShells::draw(double lower, double upper, Random& random) const {
  Eigen::VectorXi k = Eigen::VectorXi::Zero(steps_.size());
  while (k.isZero()) {
    double left = 2 * count(lower, upper) * random.uniform();
    std::size_t s = first_at(lower);
    for (; s + 1 < first_at(upper) && left >= ways_.back()[s]; ++s) left -= ways_.back()[s];
    for (int d = static_cast<int>(steps_.size()); d-- > 0;) {
      const Row& rest = ways_[static_cast<std::size_t>(d)];
      double total = rest[s];
      for (int j = 1; quanta_of(d, j) <= s; ++j) total += 2 * rest[s - quanta_of(d, j)];
      left = total * random.uniform();
      int j = 0;
      double weight = rest[s];
      while (left >= weight && quanta_of(d, j + 1) <= s) {
        left -= weight;
        ++j;
        weight = 2 * rest[s - quanta_of(d, j)];
      }
      k[d] = j > 0 && left < weight / 2 ? -j : j;
      s -= quanta_of(d, j);
    }
  }
  return k;
}

}  // namespace ccvt
