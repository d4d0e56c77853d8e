#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// The nearest of the chosen points to each point: a chosen one is its own, whatever others are in
/// the same place. Throws Stopped, as take_turned() does before it changes owners.
template <class Scalar>
std::vector<Index> nearest_chosen(PointsView<Scalar> points, std::span<const Index> chosen,
                                  const Arena& arena);

/// Points whose normals face away from that of their owner get the nearest site that they do not
/// face away from, where there is one among the 1024 nearest ones. How many did. `lifted`: points
/// with their normals, as lift() makes them; the last half of the dimensions. `chosen`: which of
/// them the sites are.
template <class Scalar>
Index take_turned(PointsView<Scalar> lifted, std::span<const Index> chosen,
                  std::vector<Index>& owners, const Arena& arena);

}  // namespace ccvt
