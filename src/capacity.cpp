#include "ccvt/capacity.h"

#include <algorithm>
#include <limits>
#include <string>

#include "numbers.h"

namespace ccvt {

std::vector<Index> equal_capacities(std::int64_t points, Index sites) {
  if (sites < 1 || sites > points) {
    throw InvalidInput("sites: " + std::to_string(sites) + " for " + std::to_string(points) +
                       " points: there must be at least one site, and no more sites than points");
  }
  const std::int64_t most = points / sites + (points % sites > 0 ? 1 : 0);
  if (most > std::numeric_limits<Index>::max()) {
    throw InvalidInput("sites: " + std::to_string(sites) + " for " + std::to_string(points) +
                       " points: a site owns at most 2147483647");
  }
  std::vector<Index> capacities(static_cast<std::size_t>(sites),
                                static_cast<Index>(points / sites));
  std::fill_n(capacities.begin(), points % sites, static_cast<Index>(most));
  return capacities;
}

void validate_capacities(std::span<const Index> capacities, std::int64_t points) {
  if (capacities.empty()) throw InvalidInput("capacities: there are none");
  std::int64_t sum = 0;
  for (std::size_t s = 0; s < capacities.size(); ++s) {
    if (capacities[s] < 1) {
      throw InvalidInput("capacities[" + std::to_string(s) + "] is " +
                         std::to_string(capacities[s]) + ": capacities must be positive");
    }
    sum += capacities[s];
  }
  if (sum != points) {
    throw InvalidInput("capacities: they sum to " + std::to_string(sum) + ", but there are " +
                       std::to_string(points) + " points: the two must be equal");
  }
}

double capacity_error(std::span<const Index> owners, Index sites) {
  if (sites < 1) throw InvalidInput("sites: " + std::to_string(sites) + " is not positive");
  if (owners.empty()) throw InvalidInput("owners: there are none");
  std::vector<double> size(static_cast<std::size_t>(sites), 0.0);  // whole numbers
  for (std::size_t p = 0; p < owners.size(); ++p) {
    if (owners[p] < 0 || owners[p] >= sites) {
      throw InvalidInput("owners[" + std::to_string(p) + "] is " + std::to_string(owners[p]) +
                         ": it must be in 0.." + std::to_string(sites - 1));
    }
    ++size[SiteNumber(owners[p])];
  }
  const double mean = static_cast<double>(owners.size()) / sites;
  double sum = 0;
  for (const double s : size) {
    const double deviation = s / mean - 1;
    sum += deviation * deviation;
  }
  return sum / sites;
}

}  // namespace ccvt
