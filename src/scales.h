#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "ccvt/types.h"
#include "parallel/arena.h"

namespace ccvt {

/// The scales at which every method works; what lies beyond is refused.
///
/// Let X bound the coordinates of m <= 2^40 points in D dimensions; sites, being means of points or
/// given, obey it too. No difference exceeds 2 X, no square of a distance 4 D X^2.
///
/// Large. In double, the largest number that is formed is m times a weight of an exact assignment,
/// which has m < 2^31, and a weight is the length of a path over at most m sites: 2^62 * 4 D X^2,
/// finite for X = 1e140 up to D = 10^9. In float, kernels add D products of two differences: 4 D
/// X^2 is finite for X = 1e17 up to D = 8192; beyond that X falls as 1 / sqrt(D).
///
/// Small. A product that underflows is off by at most half the least denormal, whatever its size.
/// Each bound on rounding has a term for that (PairCut, Screen, Pricer, SquaredDistances,
/// SiteSteps, ExactAssignment, Lloyd), so that what is decided is right at any scale, and runs end;
/// what is lost is the sight of gains of about D * 2^-1074. Of points that extend over E that is
/// nothing beside E^2 when E = 1e-140, and no quotient by an extent or its square overflows. Keys
/// in float lose their sight below 1e-19 and then prune nothing, so that the keys in double decide;
/// the quotient 1 / E is finite for E = 1e-30. Clusters of any size inside E, and points that are
/// all equal, are fine.
template <class Scalar>
constexpr double kSmallestExtent = sizeof(Scalar) == sizeof(float) ? 1e-30 : 1e-140;

/// A bound on the magnitude of coordinates.
template <class Scalar>
double largest_coordinate(int dimension) {
  constexpr double most = sizeof(Scalar) == sizeof(float) ? 1e17 : 1e140;
  return most / std::sqrt(std::max(1.0, dimension / 8192.0));
}

/// Throws InvalidInput unless all coordinates are finite and at most largest_coordinate(), in
/// Scalar's range. `argument` is what the points are called. Returns over how much they extend in
/// the dimension where that is most.
/// The first point is called argument[first_number].
template <class Scalar>
double require_moderate(const char* argument, const PointsView<Scalar>& points,
                        const Arena& arena = Arena(1), std::int64_t first_number = 0);

/// Throws InvalidInput unless points that extend over `widest` at most are all equal or extend over
/// kSmallestExtent.
template <class Scalar>
void require_extent(const char* argument, double widest);

/// The same, and that the points are all equal or extend over kSmallestExtent.
template <class Scalar>
void require_scale(const char* argument, const PointsView<Scalar>& points, const Arena& arena);

}  // namespace ccvt
