#pragma once

#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/site_state.h"

namespace ccvt {

/// Moves a site to the centroid of its cell, unless it is fixed, and renews its energy and radius
/// [eq. 2]. Before, too,
/// the radius must bound the distance of the cell's points; it may be infinite.
///
/// On a torus the centroid is that of the images of the points nearest to the site. Where moving
/// the site makes other images nearest, it moves again, until none changes; each move lowers the
/// energy.
template <class Scalar>
void update_site(const Metric& metric, const Cells<Scalar>& cells, SiteState& sites,
                 SiteNumber site);

/// A radius that rounding has not made smaller than the root of `squared`, itself rounded.
double upper_radius(double squared, int dimension);

/// What a site that is not quite at the centroid of its cell, by rounding in update_site(), can add
/// to the cell's energy, at most: the points times e^2, where e bounds how far it is off.
double energy_of_rounding(const Metric& metric, double coordinate_bound, double points,
                          double radius);

/// On the absolute values of the coordinates of a cell's points: `all`, that of all points, or less
/// where none is far away. On a torus it is always that.
double coordinate_bound_of(const Metric& metric, double all, const SiteState& sites,
                           SiteNumber site);

/// The sum of the sites' energies, in a fixed order and with an error that hardly grows with n.
double total_energy(const SiteState& sites, const Arena& arena = Arena(1));

extern template void update_site(const Metric&, const Cells<float>&, SiteState&, SiteNumber);
extern template void update_site(const Metric&, const Cells<double>&, SiteState&, SiteNumber);

}  // namespace ccvt
