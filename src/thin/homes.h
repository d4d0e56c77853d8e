#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "ccvt/types.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/loops.h"
#include "relax/site_state.h"

namespace ccvt {

/// Of a point, in the order of the homes.
using Place = Number<struct OfHomePlaces>;

/// The cells of a tessellation as bins to find points and what has been chosen of them in. They
/// hold about as many points each, however dense the cloud is, in any dimension.
template <class Scalar>
struct Homes {
  Groups<PointNumber> points;       ///< by home; places are in its items
  Buffer<Scalar> coordinates;       ///< by place
  std::vector<SiteNumber> home_of;  ///< by place
  SiteState centres;                ///< and a radius around each that holds the home's points
  /// Of each home: how near two chosen points must be to repel each other, see Repulsion.
  std::vector<double> reach;
  /// Of each home: those with points within their common reach of its points, itself among them.
  Groups<SiteNumber> near;

  [[nodiscard]] std::size_t count() const { return reach.size(); }
  [[nodiscard]] std::size_t dimension() const { return centres.dimension; }
  [[nodiscard]] const Scalar* at(Place place) const {
    return coordinates.data() + place * dimension();
  }
  [[nodiscard]] NumberRange<Place> places(SiteNumber home) const {
    return {Place(points.first[home]), Place(points.first[home + 1])};
  }
  [[nodiscard]] PointNumber point(Place place) const { return points.items[place]; }
  /// How near points of two homes repel each other.
  [[nodiscard]] double reach_of(SiteNumber a, SiteNumber b) const {
    return (reach[a] + reach[b]) / 2;
  }
};

/// Homes from the owner of every point and the centre of every cell. O((m + n) log n) where cells
/// have few neighbours. Of cells that have hundreds, as in many dimensions, only the nearest are
/// near.
template <class Scalar>
Homes<Scalar> make_homes(const Metric& metric, PointsView<Scalar> points,
                         std::span<const Index> owners, PointsView<Scalar> centres,
                         const Arena& arena);

}  // namespace ccvt
