#include "metrics/shells.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace ccvt {

namespace {

constexpr double kMostQuanta = 65536;

}  // namespace

FrequencyShells::FrequencyShells(Eigen::VectorXd steps, double highest, const Arena& arena)
    : steps_(std::move(steps)), quantum_(highest * highest / kMostQuanta) {
  const double step = steps_[0];
  cube_ = ((steps_.array() - step).abs() <= 1e-9 * step).all() &&
          highest * highest / (step * step) <= kMostQuanta;
  if (cube_) quantum_ = step * step;
  const double most = std::floor(highest * highest / quantum_ * (1 + 1e-12));
  beyond_ = most + 1;
  most_ = capped(most);
  ways_.assign(1, Row(most_ + 1, 0.0));
  ways_[0][0] = 1;
  for (int d = 0; d < steps_.size(); ++d) {
    runs_.push_back(runs_of(d));
    Row next = ways_.back();  // k = 0
    for (const Run& run : runs_.back()) {
      arena.check();
      const Row& before = ways_.back();
      for (std::size_t s = run.quanta; s <= most_; ++s) {
        next[s] += 2.0 * run.count * before[s - run.quanta];
      }
    }
    ways_.push_back(std::move(next));
  }
  ways_.back()[0] -= 1;  // k = 0 is no frequency
}

std::size_t FrequencyShells::capped(double quanta) const {
  return static_cast<std::size_t>(std::min(quanta, beyond_));
}

std::size_t FrequencyShells::quanta_of(int d, int k) const {
  if (cube_) return capped(1.0 * k * k);
  const double f = k * steps_[d];
  // In a thin box one step may be more than all.
  return capped(f * f / quantum_ + 0.5);
}

auto FrequencyShells::runs_of(int d) const -> std::vector<Run> {
  std::vector<Run> runs;
  for (int first = 1; quanta_of(d, first) <= most_;) {
    const std::size_t quanta = quanta_of(d, first);
    // The end of the run is between `inside` and `beyond`.
    int inside = first;
    int beyond = first + 1;
    while (quanta_of(d, beyond) == quanta) {
      inside = beyond;
      beyond += beyond - first;
    }
    while (beyond - inside > 1) {
      const int middle = inside + (beyond - inside) / 2;
      (quanta_of(d, middle) == quanta ? inside : beyond) = middle;
    }
    runs.push_back({quanta, first, beyond - first});
    first = beyond;
  }
  return runs;
}

/// The least number of quanta that is not below a frequency.
std::size_t FrequencyShells::first_at(double frequency) const {
  const double quanta = frequency * frequency / quantum_;
  return capped(std::ceil(quanta * (1 - 1e-12)));
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
    for (std::size_t d = runs_.size(); d-- > 0;) {
      const Row& rest = ways_[d];
      const std::vector<Run>& runs = runs_[d];
      double total = rest[s];
      std::size_t within = 0;  // runs of at most s quanta
      for (; within < runs.size() && runs[within].quanta <= s; ++within) {
        total += 2.0 * runs[within].count * rest[s - runs[within].quanta];
      }
      left = total * random.uniform();
      if (left < rest[s] || within == 0) continue;
      left -= rest[s];
      std::size_t r = 0;
      const auto each = [&] { return 2 * rest[s - runs[r].quanta]; };
      for (; r + 1 < within && left >= runs[r].count * each(); ++r) left -= runs[r].count * each();
      const double along = each() > 0 ? std::floor(left / each()) : 0;
      const int beyond = static_cast<int>(std::min(along, runs[r].count - 1.0));
      left -= beyond * each();
      const int j = runs[r].first + beyond;
      k.data()[d] = left < each() / 2 ? -j : j;
      s -= runs[r].quanta;
    }
  }
  return k;
}

}  // namespace ccvt
