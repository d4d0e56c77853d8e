#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <stdexcept>
#include <vector>

namespace ccvt::bench {

/// The middle value, or the mean of the two middle ones. There must be one.
inline double median(std::vector<double> values) {
  if (values.empty()) throw std::invalid_argument("median: of no values");
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

/// The exponent b of the power law y = a x^b that fits best: least squares of log y on log x.
/// At least two different x; all positive.
inline double growth_exponent(std::span<const double> x, std::span<const double> y) {
  if (x.size() != y.size()) throw std::invalid_argument("growth_exponent: x and y differ in size");
  double mean_x = 0;
  double mean_y = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    if (!(x[k] > 0 && y[k] > 0)) throw std::invalid_argument("growth_exponent: not positive");
    mean_x += std::log(x[k]) / static_cast<double>(x.size());
    mean_y += std::log(y[k]) / static_cast<double>(x.size());
  }
  double products = 0;
  double squares = 0;
  for (std::size_t k = 0; k < x.size(); ++k) {
    const double dx = std::log(x[k]) - mean_x;
    products += dx * (std::log(y[k]) - mean_y);
    squares += dx * dx;
  }
  if (!(squares > 0)) throw std::invalid_argument("growth_exponent: there is only one x");
  return products / squares;
}

/// Mean, smallest, largest and standard deviation (of the values themselves, not an estimate).
struct Spread {
  double mean = 0;
  double least = 0;
  double most = 0;
  double deviation = 0;
};

inline Spread spread_of(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("spread_of: no values");
  Spread spread{0, values[0], values[0], 0};
  const auto count = static_cast<double>(values.size());
  for (const double v : values) {
    spread.mean += v / count;
    spread.least = std::min(spread.least, v);
    spread.most = std::max(spread.most, v);
  }
  for (const double v : values) spread.deviation += (v - spread.mean) * (v - spread.mean) / count;
  spread.deviation = std::sqrt(spread.deviation);
  return spread;
}

}  // namespace ccvt::bench
