#include "weighted/inputs.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "checks.h"
#include "compensated_sum.h"
#include "number_text.h"

namespace ccvt {
namespace {

constexpr double kLargestTotal = 1e100;
/// So that the part of a site, a billionth, and its errors keep all their digits.
constexpr double kSmallestTotal = 1e-280;
/// By what share of the total mass the capacities may miss it.
constexpr double kCapacityRounding = 1e-6;

std::string nth(const char* what, std::size_t k, double value) {
  return std::string(what) + "[" + std::to_string(k) + "] is " + text(value);
}

double sum_of_masses(std::span<const double> masses, std::size_t points) {
  if (masses.size() != points) {
    throw InvalidInput("masses: there are " + std::to_string(masses.size()) + " for " +
                       std::to_string(points) + " points: there must be one per point");
  }
  CompensatedSum sum;
  for (std::size_t p = 0; p < masses.size(); ++p) {
    if (!(masses[p] >= 0 && masses[p] <= kLargestTotal)) {
      throw InvalidInput(nth("masses", p, masses[p]) + ": it must be finite, not negative and at " +
                         "most " + text(kLargestTotal));
    }
    sum.add(masses[p]);
  }
  if (!(sum.value() > 0)) throw InvalidInput("masses: all are 0: some must be positive");
  if (sum.value() > kLargestTotal || sum.value() < kSmallestTotal) {
    throw InvalidInput("masses: they sum to " + text(sum.value()) + ": it must be at least " +
                       text(kSmallestTotal) + " and at most " + text(kLargestTotal));
  }
  return sum.value();
}

void check_capacities(std::span<const double> capacities, std::size_t sites, double total) {
  if (capacities.size() != sites) {
    throw InvalidInput("capacities: there are " + std::to_string(capacities.size()) + " for " +
                       std::to_string(sites) + " sites: there must be one per site");
  }
  CompensatedSum sum;
  for (std::size_t s = 0; s < capacities.size(); ++s) {
    if (!(capacities[s] > 0 && capacities[s] <= kLargestTotal)) {
      throw InvalidInput(nth("capacities", s, capacities[s]) +
                         ": it must be a positive finite mass");
    }
    sum.add(capacities[s]);
  }
  if (std::abs(sum.value() - total) <= kCapacityRounding * total) return;
  throw InvalidInput("capacities: they sum to " + text(sum.value()) + ", the masses to " +
                     text(total) + ": the two must be equal");
}

/// Capacities scaled to sum to `total`; equal ones when there are none.
std::vector<double> scaled_capacities(std::span<const double> given, std::size_t sites,
                                      double total) {
  std::vector<double> capacities(sites, total / static_cast<double>(sites));
  if (given.empty()) return capacities;
  CompensatedSum sum;
  for (const double capacity : given) sum.add(capacity);
  capacities.assign(given.begin(), given.end());
  for (double& capacity : capacities) capacity *= total / sum.value();
  return capacities;
}

/// Throws when the heaviest point does not fit the smallest capacity; `equal`: all are the same.
void require_room(const MassInputs& inputs, std::span<const double> masses, bool equal) {
  const auto heaviest = std::max_element(inputs.masses.begin(), inputs.masses.end());
  const auto smallest = std::min_element(inputs.capacities.begin(), inputs.capacities.end());
  constexpr double kRounding = 1 + 1e-12;
  if (*heaviest <= *smallest * kRounding) return;
  const auto point = static_cast<std::size_t>(heaviest - inputs.masses.begin());
  const auto heavy = std::count_if(inputs.masses.begin(), inputs.masses.end(),
                                   [&](double mass) { return mass > *smallest * kRounding; });
  std::string message = nth("masses", point, masses[point]) + ", more than the capacity of site " +
                        std::to_string(smallest - inputs.capacities.begin()) + ", " +
                        text(*smallest / inputs.scale, 6) +
                        " (too heavy: " + std::to_string(heavy) +
                        (heavy == 1 ? " point" : " points") + "): whole points must fit";
  if (equal) {
    const auto most = static_cast<Index>(inputs.total / *heaviest * kRounding);
    message +=
        ", as they do with at most " + std::to_string(most) + (most == 1 ? " site" : " sites");
  }
  throw InvalidInput(message + "; the method resampled shares heavy points among sites");
}

}  // namespace

MassInputs::MassInputs(std::span<const double> given, std::size_t points, Index sites,
                       const MassOptions& options) {
  require_enumerator("method", options.method, MassMethod::resampled);
  const double sum = sum_of_masses(given, points);
  const auto count = static_cast<std::size_t>(sites);
  if (!options.capacities.empty()) check_capacities(options.capacities, count, sum);
  const auto positive = std::count_if(given.begin(), given.end(), [](double m) { return m > 0; });
  scale = std::exp2(-std::ilogb(sum / static_cast<double>(positive)));
  masses.reserve(given.size());
  CompensatedSum scaled;
  for (const double mass : given) {
    masses.push_back(mass * scale);
    scaled.add(masses.back());
  }
  total = scaled.value();
  capacities = scaled_capacities(options.capacities, count, total);
  if (options.method == MassMethod::whole) require_room(*this, given, options.capacities.empty());
}

}  // namespace ccvt
