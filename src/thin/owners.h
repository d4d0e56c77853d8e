#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"
#include "spatial/site_tree.h"

namespace ccvt {

/// Whether normals of two points face apart; `lifted` as below.
template <class Scalar>
bool face_away(PointsView<Scalar> lifted, Index a, Index b);

/// Where the chosen points are, one after the other.
template <class Scalar>
std::vector<double> positions_of(PointsView<Scalar> points, std::span<const Index> chosen);

/// The sites nearest to a point that it does not face away from, at most `count`, nearest first; of
/// the 1024 nearest ones. `lifted`: points with their normals, as lift() makes them; the last half
/// of the dimensions. `chosen`: which of them the sites are; `tree`: their positions_of().
template <class Scalar>
std::vector<Index> nearest_alike(PointsView<Scalar> lifted, Index point,
                                 std::span<const Index> chosen, const SiteTree& tree,
                                 std::size_t count = 1);

/// The nearest of the chosen points to each point: a chosen one is its own, whatever others are in
/// the same place. Throws Stopped, as take_turned() does before it changes owners.
template <class Scalar>
std::vector<Index> nearest_chosen(PointsView<Scalar> points, std::span<const Index> chosen,
                                  const Arena& arena);

/// Points whose normals face away from that of their owner get the nearest site that they do not
/// face away from, where there is one, see nearest_alike(). How many did.
template <class Scalar>
Index take_turned(PointsView<Scalar> lifted, std::span<const Index> chosen,
                  std::vector<Index>& owners, const Arena& arena);

}  // namespace ccvt
