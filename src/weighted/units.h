#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "numbers.h"

namespace ccvt {

/// The points that `count` unit points stand for, by systematic sampling [Madow 1949]: the masses
/// of the points in `order` are laid along a line, and a unit point is put at each
/// (total / count)-th of it, from an offset that the seed draws. A point gets the whole part of its
/// mass in units or one more; all positive masses of a stretch of the line together, too.
std::vector<PointNumber> units_along(std::span<const PointNumber> order,
                                     std::span<const double> masses, double total, Index count,
                                     std::uint64_t seed);

/// Of each of the capacities, its part of `count` units, rounded such that they sum to that, and at
/// least one. There are no more capacities than units.
std::vector<Index> capacities_in_units(std::span<const double> capacities, Index count);

/// The sites that own unit points of one point, and how many each: the most first, of equally many
/// the one with the lower number.
struct UnitOwner {
  Index site;
  Index units;
};
/// Calls visit(point, owners) for each point that has unit points, in the order of the line.
/// `unit_owners`: the owner of each.
template <class Visit>
void for_each_divided(std::span<const PointNumber> units, std::span<const Index> unit_owners,
                      const Visit& visit);

/// Counts how often each site occurs, as UnitOwner says.
void count_owners(std::span<const Index> owners, std::vector<UnitOwner>& counted);

template <class Visit>
void for_each_divided(std::span<const PointNumber> units, std::span<const Index> unit_owners,
                      const Visit& visit) {
  std::vector<UnitOwner> counted;
  for (std::size_t begin = 0, end = 0; begin < units.size(); begin = end) {
    while (end < units.size() && units[end] == units[begin]) ++end;
    count_owners(unit_owners.subspan(begin, end - begin), counted);
    visit(units[begin], std::span<const UnitOwner>(counted));
  }
}

}  // namespace ccvt
