#pragma once

#include <vector>

#include "ccvt/metrics.h"

namespace ccvt {

struct FrequencyPower {
  double frequency = 0;
  double power = 0;
};

/// Shells of frequencies that differ by less than 2 %; f and -f are given once, in any order.
std::vector<LowShell> low_shells(std::vector<FrequencyPower> frequencies);

/// The straight line through log power over log frequency; see Spectrum::low_frequency_slope.
struct PowerLaw {
  double slope = 0;
  double error = 0;
  double scale = 0;  ///< power at frequency 1
};
/// Of shells that all have power; all NaN unless there are two.
PowerLaw fit_power_law(const std::vector<LowShell>& shells, int sets);

/// Mean and variance of the log of a sum of `count` independent exponential variables of mean 1:
/// digamma and trigamma, count >= 1 [Abramowitz, Stegun 1964, 6.3.5, 6.3.18, 6.4.6, 6.4.12].
double digamma(double count);
double trigamma(double count);

}  // namespace ccvt
