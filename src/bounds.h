#pragma once

#include <algorithm>
#include <utility>

#include "ccvt/problem.h"
#include "geometry/coordinate_range.h"
#include "geometry/fitted.h"
#include "geometry/torus.h"

namespace ccvt {

/// Throws InvalidInput for a problem that was moved from; others have sites.
template <class Scalar>
void require_sites(const Problem<Scalar>& problem) {
  if (problem.site_count() == 0) {
    throw InvalidInput("problem: it has no sites, as one that was moved from");
  }
}

/// Of all ranks, where there are some.
template <class Scalar>
Box box_around_points(const Problem<Scalar>& problem, const Arena& arena) {
  if (problem.ranks() == nullptr) return box_around(problem.points(), arena);
  return problem.box_of_ranks();
}

/// The problem's box, or the smallest around its points.
template <class Scalar>
Box bounding_box(const Problem<Scalar>& problem, const Arena& arena) {
  return problem.domain().has_box() ? problem.domain().box() : box_around_points(problem, arena);
}

/// Of a problem, with the sites that are given.
template <class Scalar>
Domain measured_domain(const Problem<Scalar>& problem) {
  if (!problem.domain().is_partly_periodic()) return problem.domain();
  Box around = box_around_points(problem, Arena(1));
  around = widened(std::move(around), view_points(problem.initial_sites()));
  around = widened(std::move(around), view_points(problem.fixed_sites()));
  return fitted(problem.domain(), around);
}

/// Where sites are looked for: the torus, or else the bounding box.
inline Box search_box(const Domain& domain, const Box& bounding_box) {
  return domain.is_periodic() ? torus_of(domain) : bounding_box;
}

/// On the absolute values of all coordinates in it.
inline double largest_coordinate(const Box& box) {
  return std::max(box.lower.eigen().cwiseAbs().maxCoeff(), box.upper.eigen().cwiseAbs().maxCoeff());
}

/// The same of points and sites. `measured`, `bounding_box`: those of the problem, see above. A box
/// that is not periodic may be much wider than the points, and does not count.
template <class Scalar>
double largest_coordinate(const Problem<Scalar>& problem, const Domain& measured,
                          const Box& bounding_box, const Arena& arena) {
  const auto around = [&] {
    if (measured.is_periodic()) return measured.box();
    return measured.has_box() ? box_around_points(problem, arena) : bounding_box;
  };
  double largest = largest_coordinate(around());
  const Columns<Scalar>& fixed = problem.fixed_sites();
  if (fixed.size() > 0) largest = std::max(largest, double{fixed.eigen().cwiseAbs().maxCoeff()});
  return largest;
}

}  // namespace ccvt
