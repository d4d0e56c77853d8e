#pragma once

#include <span>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/domain.h"
#include "ccvt/export.h"
#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

/// Points with masses: a weighted sample, a histogram whose cells are points, particles.
namespace ccvt {

/// What becomes of points that are heavier than what a cell has room for.
enum class MassMethod {
  /// Every point has one owner, whole. The mass of a cell differs from its capacity by less than
  /// the mass of the heaviest point, and mostly by less than half a point of mean mass; no point
  /// may be heavier than the smallest capacity.
  whole,
  /// The masses become unit points, by stratified resampling, that are tessellated in their place:
  /// capacities are exact in units, heavy points are shared by several cells, and light ones
  /// stand for those near them.
  resampled,
};

/// The words of the enumerators: "whole", "resampled".
CCVT_EXPORT const char* to_string(MassMethod method);

/// How points with masses are tessellated.
struct CCVT_EXPORT MassOptions {
  MassMethod method = MassMethod::whole;
  /// Unit points for each site: all of what `resampled` works with, and where `whole` starts from.
  /// At least 1.
  Index points_per_site = 256;
  /// As for Problem::set_domain().
  Domain domain = {};
  /// The mass that each site is to own: positive and finite; they sum to the mass of all points, to
  /// within a millionth of it, and are scaled to do so exactly. Empty: equal.
  std::vector<double> capacities = {};
  /// Of the unit points. Of these, `threads`, `seed`, `max_iterations`, `energy_tolerance`,
  /// `time_limit`, `until`, `descent_points`, `on_iteration` and `cancelled` count for the
  /// exchanges of whole points, too.
  Options relaxation = {};

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;
};

/// Of the mass of a point, what a site owns.
struct MassShare {
  Index point = 0;
  Index site = 0;
  double mass = 0;
};

/// What tessellate_masses() returns. Masses are in the units of those given.
template <class Scalar>
struct MassResult {
  /// #dimensions by n: the centre of mass of each cell; on a torus of the images nearest to it.
  Columns<Scalar> sites;
  /// The owner of each point, in 0..n-1. Resampled: the site that owns most of its unit points, of
  /// several the first one; of a point without any the nearest site,
  /// before sites move to the centres of mass of all shares.
  std::vector<Index> owners;
  /// What each point's mass is divided into, by point; resampled only, else empty.
  std::vector<MassShare> shares;
  /// The mass of each cell. Resampled: of its shares.
  std::vector<double> masses;
  /// What it is to be: the capacities given, scaled, or equal ones.
  std::vector<double> capacities;
  double total_mass = 0;
  /// The largest |mass - capacity| of a cell, and which cell that is.
  double largest_mass_error = 0;
  Index worst_site = 0;
  /// The root of the mean of (mass / capacity - 1)^2 over cells.
  double relative_mass_error = 0;
  /// Whole: the mass of the heaviest point; every |mass - capacity| is below it, whatever the
  /// points, also of a run that ended early. Resampled: infinite, as there is no such bound:
  /// capacities are exact in units of total_mass / (n * points_per_site).
  double mass_error_bound = 0;
  /// Points that more than one site owns a share of. Whole: 0.
  Index shared_points = 0;
  /// Energies are sums of mass times squared distance, of shares where there are some. The
  /// normalized energy has the total mass in place of the number of points; capacity_error is that
  /// of masses. `stable`: see tessellate_masses(). Of the phases, those of unit points, and
  /// "masses": all that is done with whole points or shares.
  Summary summary;

  /// "largest mass error 0.8 % of its cell's capacity, bound 2.1 %": of the cell that misses the
  /// largest share of its own.
  [[nodiscard]] CCVT_EXPORT std::string brief_error() const;
};

/// Tessellates points with masses: n sites, each the centre of mass of its cell, whose masses are
/// the capacities as nearly as single points allow.
///
/// `points`: as for Problem. `masses`: one a point, finite and not negative; they sum to
/// 1e-280 at least and 1e100 at most. A point of mass 0 counts for nothing and belongs to the
/// nearest site. `sites` times `points_per_site` is less than 2^31. Sites can neither be given nor
/// fixed here; points can be mapped before, and sites back, by a LinearMap.
///
///     auto result = ccvt::tessellate_masses(points, masses, 1000, {.relaxation = {.seed = 7}});
///
/// Both methods lay the points along a Hilbert curve and put a unit point at every
/// (total / (n * points_per_site))-th of the mass on it, from an offset that the seed draws:
/// systematic sampling [Madow 1949], in which a point gets the whole part of its mass in units or
/// one more. These are tessellated as any points are.
///
/// `whole` goes on with the points themselves. Each goes to the site of most of its unit points, or
/// to the nearest one; mass is evened out between neighbouring cells until every error is below
/// the bound; then pairs of cells exchange points. A pair does what lowers the energy most of: a
/// cut of the points of both, in the order of their squared distance to one site less that to the
/// other; such a cut of the lighter points; and moving one point or exchanging two. Of all three it
/// may do only what leaves |error of one - error of the other| and the larger of the two no larger
/// than they were, or than half the mean mass of the points of both. `stable`: no pair whose
/// bounding spheres meet has anything left to do, and every site is the centre of mass of its cell.
/// That happens after finitely many sweeps, as each lowers the energy. (Where more than 64 n, and
/// more than a million, pairs of spheres meet, as in many dimensions, a pair is a site and one of
/// its 32 nearest.) With equal masses that is the stable of the unit tessellation.
///
/// One seed gives the same bits for any number of threads. Time, beside that of the unit points: of
/// `whole` per sweep O(m log(m / n)) for cells that have changed and their neighbours, and O(m) for
/// the rest. Memory beside the points: that of tessellating n * points_per_site points, these
/// points, and about 40 bytes a point.
///
/// Throws InvalidInput for bad input, of `whole` also when a point is heavier than the smallest
/// capacity; Cancelled when the run is cancelled before there are unit points. Cancelled later, it
/// ends with what has been reached: all masses within the bound, and sites at the centres of mass.
template <class Scalar>
CCVT_EXPORT MassResult<Scalar> tessellate_masses(PointsView<Scalar> points,
                                                 std::span<const double> masses, Index sites,
                                                 const MassOptions& options = {});
template <class Derived>
auto tessellate_masses(const Eigen::DenseBase<Derived>& points, std::span<const double> masses,
                       Index sites, const MassOptions& options = {}) {
  return tessellate_masses(view_points(points), masses, sites, options);
}
template <class Scalar>
MassResult<Scalar> tessellate_masses(const Columns<Scalar>& points, std::span<const double> masses,
                                     Index sites, const MassOptions& options = {}) {
  return tessellate_masses(view_points(points), masses, sites, options);
}

}  // namespace ccvt
