#pragma once

#include <span>
#include <vector>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// What faces one way: points, and the sites that are to own them.
struct Side {
  std::vector<Index> points;  ///< ascending
  std::vector<Index> sites;   ///< ascending
};

/// The sides of a cloud. A site is on one with the 6 nearest that it does not face away from, see
/// nearest_alike(), and a point on that of the nearest: two sheets that face apart are two sides,
/// one that is bent round an edge is one. So are all parts of which no site faces away from one of
/// the 6 that are nearest to it, normals aside. `lifted`, `chosen`: as take_turned() has them.
/// Throws Stopped.
template <class Scalar>
std::vector<Side> sides_of(PointsView<Scalar> lifted, std::span<const Index> chosen,
                           const Arena& arena);

}  // namespace ccvt
