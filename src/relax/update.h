#pragma once

#include "geometry/metric.h"
#include "parallel/arena.h"
#include "relax/cells.h"
#include "relax/patches.h"
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

/// The same by what is known of a cell that has exchanged a few points since update_site() summed
/// all of them up; false where they are too many, or more has to be looked at. O(D). The radius
/// does not become smaller.
///
/// Rounding, of the mean of m points, in radii and halves of a unit in the last place, by which
/// energy_of_rounding() allows for 2 (m / 8 + 16): the sum of all points in eight lanes takes
/// m / 8 + 8 of it; sums of the differences that k <= m / 8 exchanges make, k^2 / m + 4 k / m,
/// which is m / 64 + 1/2; and a coordinate that is rounded a second time, when the mean of these is
/// added to the centre, at most the m / 16 that are looked at. The radius must not shrink
/// meanwhile.
template <class Scalar>
bool update_by_sums(const Metric& metric, Patches<Scalar>& patches, SiteState& sites,
                    SiteNumber site, Index points);

/// After update_site(): from now on the exchanges of a cell are summed up, if it is divided.
template <class Scalar>
void begin_sums(Patches<Scalar>& patches, const SiteState& sites, SiteNumber site);

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
extern template bool update_by_sums(const Metric&, Patches<float>&, SiteState&, SiteNumber, Index);
extern template bool update_by_sums(const Metric&, Patches<double>&, SiteState&, SiteNumber, Index);
extern template void begin_sums(Patches<float>&, const SiteState&, SiteNumber);
extern template void begin_sums(Patches<double>&, const SiteState&, SiteNumber);

}  // namespace ccvt
