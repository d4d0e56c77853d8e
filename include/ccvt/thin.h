#pragma once

#include <cstdint>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/options.h"
#include "ccvt/summary.h"
#include "ccvt/types.h"

namespace ccvt {

/// How points are thinned.
struct CCVT_EXPORT ThinOptions {
  /// How much the directions of normals count, where there are any: what faces the opposite way is
  /// as far away as 2 * normal_weight spacings of the chosen points. With much more than the
  /// default, noise in normals brings chosen points near each other. From 0 to 100.
  double normal_weight = 0.5;
  /// Chosen points are moved apart. Without, each is the point
  /// nearest to the centroid of its cell: faster, but neighbours come near each other where cells
  /// have few points.
  bool spread = true;
  /// Each chosen point stands for as many points as the next, some of which are nearer to others:
  /// the fewer points a cell has, the farther it reaches. Without, points count for the nearest
  /// chosen one, on their own side where there are normals, and counts differ.
  bool equal_counts = false;
  /// Of the cells in which points are chosen first. Its seed, threads, time limit and `cancelled`
  /// hold for all that is done, but that all points get their owners after it ended, O(m log n);
  /// its max_iterations are those of each tessellation: equal_counts makes one more of each side.
  /// Until blue_noise, as choices are to have no lattices.
  Options tessellation = Options::samples();

  /// Throws InvalidInput naming the first field outside its bounds.
  void validate() const;
};

/// Some of the points, evenly spread, and what each stands for.
struct Thinning {
  /// n numbers of points, ascending, all different.
  std::vector<Index> chosen;
  /// Of each of the m points, for which of the chosen ones it counts: in 0..n-1. A chosen point
  /// counts for itself.
  std::vector<Index> owners;
  /// n: how many points count for each, itself among them. They sum to m. With equal_counts they
  /// are floor(m / n) or more by one; where there are normals, m and n are those of each side that
  /// faces apart from others, but for what `turned` says.
  std::vector<Index> counts;
  /// Sum of squared distances of all points to the chosen ones they count for, normals aside.
  double energy = 0;
  /// How far the chosen points would be apart if they were packed as densely as can be, in the
  /// median and as far as a sample tells; the unit of ThinOptions::normal_weight. 0 where n is 1,
  /// or all of the sample lies in few places: normals do not count then.
  double spacing = 0;
  /// How often a chosen point gave way to one near it, and to one anywhere.
  std::int64_t moves = 0;
  std::int64_t jumps = 0;
  /// Points whose normals face away from the nearest chosen point, or with equal_counts from that
  /// of the cell that had room for them. They count for the nearest that they do not face away
  /// from.
  Index turned = 0;
  /// Of the tessellation; its seconds and how it ended are those of the whole.
  Summary summary;
};

/// Chooses `sites` of the points, so that the chosen ones are far apart, every point is near to
/// one, and they are as dense as the points are, within a tolerance.
///
/// The points are tessellated into cells of equal capacity, and in each the point nearest to the
/// centroid is chosen. These choices repel each other: two that are d apart by (1 - d / r)^8, the
/// weight of sample elimination [C. Yuksel, Sample Elimination for Generating Poisson Disk Sample
/// Sets, Computer Graphics Forum 34 (2), 2015], where r is the local spacing. They move to points
/// near them, and from crowds to gaps anywhere, for as long as that lowers the sum over all pairs
/// and keeps the density: of the cells of any block of 8, 16, 32, … (k) that bisection of space
/// makes, as many points are chosen as there are cells, but for max(1, s sqrt(k n / m)), with s
/// 3, within chance, or .5 where the density changes in the block. What is smaller than the
/// distance between chosen points they cannot follow: at an edge they line up along it.
///
/// With equal_counts cells are made anew at last, with the chosen points as sites that stay: their
/// capacities are kept, and no exchange of points between two cells lowers the energy. With normals
/// each side of the cloud is divided by itself: a chosen point is on one with the 6 nearest that it
/// does not face away from, and other points are on that of the nearest such. Two sheets that face
/// apart are two, a sheet that is bent round its edge is one, and so are all parts near which
/// nothing faces apart. Out of time, all is divided at once.
///
/// `points`: #dimensions by m, as ccvt::Problem takes them; `sites`: 1 <= n <= m. `normals`: none,
/// or one a point, #dimensions by m, finite, of any length; of those of length 0 nothing is known.
/// With them a cell has no points that face away from its chosen one, if there is any among the
/// 1024 nearest that they do not face away from: two sides of a thin sheet are not mixed.
///
/// Time near-linear in m where cells have few neighbours, that is on curves, surfaces and in space.
/// Any number of threads gives identical bits. When cancelled or out of time, it returns what it
/// has reached, which is a valid choice; cancelled before owners are known, points count for the
/// cell they are in, whatever equal_counts and normals say. Throws InvalidInput for bad points,
/// normals and options.
template <class Scalar>
CCVT_EXPORT Thinning thin(PointsView<Scalar> points, Index sites, const ThinOptions& options = {},
                          PointsView<Scalar> normals = {});
/// The same of Eigen's matrices:
///
///     const ccvt::Thinning few = ccvt::thin(points, 20000);
template <class Derived>
Thinning thin(const Eigen::DenseBase<Derived>& points, Index sites,
              const ThinOptions& options = {}) {
  return thin(view_points(points), sites, options);
}
template <class Derived, class Normals>
Thinning thin(const Eigen::DenseBase<Derived>& points, Index sites, const ThinOptions& options,
              const Eigen::DenseBase<Normals>& normals) {
  return thin(view_points(points), sites, options, view_points(normals));
}
/// The same of what readers return.
template <class Scalar>
Thinning thin(const Columns<Scalar>& points, Index sites, const ThinOptions& options = {},
              const Columns<Scalar>& normals = {}) {
  return thin(view_points(points), sites, options, view_points(normals));
}

}  // namespace ccvt
