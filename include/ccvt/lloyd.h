#pragma once

#include <vector>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/options.h"
#include "ccvt/problem.h"
#include "ccvt/solver.h"

namespace ccvt {

namespace detail {
template <class Scalar>
struct LloydResult {
  Columns<Scalar> sites;
  std::vector<Index> owners;
  Summary summary;
};
template <class Scalar>
CCVT_EXPORT LloydResult<Scalar> lloyd(const Problem<Scalar>& problem, const Options& options);
}  // namespace detail

/// Lloyd relaxation of discrete points [3, eq. 2 to 4]: every point is owned by its nearest site,
/// every site moves to the centroid of its points, again and again. No capacities: those of the
/// problem are not kept, and Summary::capacity_error says how unequal the cells became. The
/// baseline that capacity constraints are measured against; also known as k-means.
///
/// The sites start where tessellate() would start them for the same problem and seed; given owners
/// are what the first centroids are made of. A site without points stays where it is.
///
/// Of the options, `threads`, `seed`, `max_iterations`, `energy_tolerance`, `time_limit`,
/// `on_iteration` and `cancelled` count; the others are about exchanges between sites. Ends as
/// `stable` when a pass over all points changes no owner: each point is then owned by its nearest
/// site, up to rounding, and each site is the centroid of its points. That happens after finitely
/// many iterations. With any other end the sites are the centroids of the cells returned; a run
/// that is cancelled before all points have an owner takes no longer for that than a third of a
/// second, and else deals them out evenly in their order. Bit-identical for any number of threads.
///
/// In the summary, `exchanged` counts the points that changed owner after the first assignment,
/// which is the initialization "nearest"; there are no pairs and no swaps.
///
/// An iteration takes O(m + n log n), of which the m are hardly more than read: a bound on how much
/// nearer each point's owner is than other sites tells which points to look at [Hamerly 2010]. With
/// fewer than 40 points a site, or more than 64 D sites in D > 6 dimensions, all are looked
/// at, by a grid or k-d tree of the sites. Memory, beside the points: a copy of them at times, and
/// about 20 bytes a point. Throws InvalidInput for bad options, and for a problem of several
/// ranks.
template <class Scalar>
Result<Scalar> lloyd(const Problem<Scalar>& problem, const Options& options = {}) {
  auto [sites, owners, summary] = detail::lloyd(problem, options);
  return {std::move(sites), std::move(owners), std::move(summary)};
}

/// `points` (#dimensions by m, one a column, float or double) in Euclidean space.
template <class Derived>
auto lloyd(const Eigen::DenseBase<Derived>& points, Index sites, const Options& options = {}) {
  using Scalar = typename Derived::Scalar;
  return lloyd(Problem<Scalar>(view_points(points), sites, options.threads), options);
}
template <class Scalar>
Result<Scalar> lloyd(const Columns<Scalar>& points, Index sites, const Options& options = {}) {
  return lloyd(points.eigen(), sites, options);
}

}  // namespace ccvt
