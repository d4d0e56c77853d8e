#include "metrics/slope.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace ccvt {

namespace {

constexpr double kShellWidth = 0.02;
constexpr double kAsymptotic = 8;  ///< from here on the series below are exact to 1e-9

}  // namespace

double digamma(double count) {
  double sum = 0;
  for (; count < kAsymptotic; ++count) sum -= 1 / count;
  const double s = 1 / (count * count);
  return sum + std::log(count) - 0.5 / count - s * (1.0 / 12 - s * (1.0 / 120 - s / 252));
}

double trigamma(double count) {
  double sum = 0;
  for (; count < kAsymptotic; ++count) sum += 1 / (count * count);
  const double s = 1 / (count * count);
  return sum + 1 / count + s / 2 + s / count * (1.0 / 6 - s * (1.0 / 30 - s * (1.0 / 42 - s / 30)));
}

std::vector<LowShell> low_shells(std::vector<FrequencyPower> frequencies) {
  std::stable_sort(
      frequencies.begin(), frequencies.end(),
      [](const FrequencyPower& a, const FrequencyPower& b) { return a.frequency < b.frequency; });
  std::vector<LowShell> shells;
  double first = 0;
  double logs = 0;
  const auto close = [&] {
    if (shells.empty()) return;
    LowShell& shell = shells.back();
    shell.frequency = std::exp(logs / shell.frequencies);
    shell.power /= shell.frequencies;
  };
  for (const FrequencyPower& each : frequencies) {
    if (shells.empty() || each.frequency > first * (1 + kShellWidth)) {
      close();
      shells.emplace_back();
      first = each.frequency;
      logs = 0;
    }
    ++shells.back().frequencies;
    shells.back().power += each.power;
    logs += std::log(each.frequency);
  }
  close();
  return shells;
}

PowerLaw fit_power_law(const std::vector<LowShell>& shells, int sets) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (shells.size() < 2) return {none, none, none};
  struct Place {
    double weight;
    double x;
    double y;
  };
  std::vector<Place> places;
  double weight = 0;
  double x = 0;
  double y = 0;
  for (const LowShell& shell : shells) {
    const double count = shell.frequencies * sets;
    const double bias = digamma(count) - std::log(count);
    places.push_back(
        {1 / trigamma(count), std::log(shell.frequency), std::log(shell.power) - bias});
    weight += places.back().weight;
    x += places.back().weight * places.back().x;
    y += places.back().weight * places.back().y;
  }
  x /= weight;
  y /= weight;
  double xx = 0;
  double xy = 0;
  for (const Place& place : places) {
    xx += place.weight * (place.x - x) * (place.x - x);
    xy += place.weight * (place.x - x) * (place.y - y);
  }
  PowerLaw law;
  law.slope = xy / xx;
  law.scale = std::exp(y - law.slope * x);
  double chi_squared = 0;
  for (const Place& place : places) {
    const double off = place.y - y - law.slope * (place.x - x);
    chi_squared += place.weight * off * off;
  }
  const auto free = static_cast<double>(places.size() - 2);
  law.error = std::sqrt((free > 0 ? std::max(1.0, chi_squared / free) : 1) / xx);
  return law;
}

}  // namespace ccvt
