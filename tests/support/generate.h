#pragma once

#include <cstdint>
#include <vector>

#include "ccvt/domain.h"
#include "ccvt/types.h"

namespace ccvt::test {

/// How points lie in their box. All but `random` and `clusters` are full of ties.
enum class Layout {
  random,
  /// A grid: every distance occurs many times.
  grid,
  /// Five clouds, a hundredth of the box wide.
  clusters,
  /// Random places with seven points at each.
  duplicates,
  /// All points in two places.
  two_places,
  /// All points in one place, whose coordinates have no short binary form.
  one_place,
};

inline constexpr Layout all_layouts[] = {Layout::random,     Layout::grid,       Layout::clusters,
                                         Layout::duplicates, Layout::two_places, Layout::one_place};

const char* name_of(Layout layout);

/// Not a cube, of negative and positive coordinates, and away from the origin.
Box uneven_box(int dimension);

/// #dimensions by #count, in [lower, upper].
template <class Scalar>
Points<Scalar> make_points(Layout layout, const Box& box, Index count, std::uint64_t seed = 1);

/// `sites` numbers from 1 to 1000, both of which occur, most of them small.
std::vector<Index> unequal_capacities(Index sites, std::uint64_t seed = 1);

Index sum_of(const std::vector<Index>& capacities);

}  // namespace ccvt::test
