#pragma once

#include <cstdint>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// How far `sites` of the points would be apart if they were packed as densely as can be, from how
/// far as many random ones are from their nearest, in the median: strays say nothing. 0 for one
/// site, and where all of those are in one place.
template <class Scalar>
double typical_spacing(PointsView<Scalar> points, Index sites, std::uint64_t seed,
                       const Arena& arena);

/// Points with their normals, of length `length`, as further dimensions. A normal of length 0 stays
/// one. Throws InvalidInput unless normals are finite.
template <class Scalar>
Points<Scalar> lift(PointsView<Scalar> points, PointsView<Scalar> normals, double length,
                    const Arena& arena);

}  // namespace ccvt
