#include "weighted/units.h"

#include <algorithm>
#include <cmath>
#include <queue>
#include <utility>

#include "compensated_sum.h"
#include "random.h"
#include "streams.h"

namespace ccvt {

std::vector<PointNumber> units_along(std::span<const PointNumber> order,
                                     std::span<const double> masses, double total, Index count,
                                     std::uint64_t seed) {
  const double offset = Random(seed, streams::mass_offset).uniform();
  const double unit = total / count;
  std::vector<PointNumber> units;
  units.reserve(static_cast<std::size_t>(count));
  CompensatedSum before;
  for (std::size_t k = 0; k < order.size(); ++k) {
    before.add(masses[order[k]]);
    // Marks are at (j + offset) * unit; rounding may neither lose the last one nor add one.
    const double marks = std::ceil(before.value() / unit - offset);
    const double until = k + 1 == order.size() ? count : std::min<double>(marks, count);
    while (static_cast<double>(units.size()) < until) units.push_back(order[k]);
  }
  return units;
}

std::vector<Index> capacities_in_units(std::span<const double> capacities, Index count) {
  CompensatedSum total;
  for (const double capacity : capacities) total.add(capacity);
  std::vector<Index> units(capacities.size());
  CompensatedSum before;
  Index given = 0;
  std::int64_t missing = 0;
  for (std::size_t s = 0; s < capacities.size(); ++s) {
    before.add(capacities[s]);
    const bool last = s + 1 == capacities.size();
    const auto until = last ? count
                            : static_cast<Index>(std::min<std::int64_t>(
                                  count, std::llround(before.value() / total.value() * count)));
    units[s] = until - given;
    given = until;
    if (units[s] > 0) continue;
    units[s] = 1;
    ++missing;
  }
  // What sites without a unit got comes from those that have most.
  std::priority_queue<std::pair<Index, Index>> most;
  for (std::size_t s = 0; s < units.size() && missing > 0; ++s) {
    if (units[s] > 1) most.emplace(units[s], -static_cast<Index>(s));
  }
  for (; missing > 0; --missing) {
    const auto [held, site] = most.top();
    most.pop();
    --units[SiteNumber(-site)];
    most.emplace(held - 1, site);
  }
  return units;
}

void count_owners(std::span<const Index> owners, std::vector<UnitOwner>& counted) {
  std::vector<Index> sorted(owners.begin(), owners.end());
  std::sort(sorted.begin(), sorted.end());
  counted.clear();
  for (const Index site : sorted) {
    if (counted.empty() || counted.back().site != site) counted.push_back({site, 0});
    ++counted.back().units;
  }
  std::stable_sort(counted.begin(), counted.end(),
                   [](const UnitOwner& a, const UnitOwner& b) { return a.units > b.units; });
}

}  // namespace ccvt
