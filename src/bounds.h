#pragma once

#include <algorithm>

#include "ccvt/problem.h"
#include "geometry/coordinate_range.h"
#include "geometry/fitted.h"
#include "geometry/torus.h"

namespace ccvt {

/// The problem's box, or the smallest around its points.
template <class Scalar>
Box bounding_box(const Problem<Scalar>& problem, const Arena& arena) {
  return problem.domain().has_box() ? problem.domain().box() : box_around(problem.points(), arena);
}

/// Of a problem, with the sites that are given.
template <class Scalar>
Domain measured_domain(const Problem<Scalar>& problem) {
  return measured_domain(problem.domain(), problem.points(), view_points(problem.initial_sites()),
                         view_points(problem.fixed_sites()));
}

/// Where sites are looked for: the torus, or else the bounding box.
inline Box search_box(const Domain& domain, const Box& bounding_box) {
  return domain.is_periodic() ? torus_of(domain) : bounding_box;
}

/// On the absolute values of all coordinates in it.
inline double largest_coordinate(const Box& box) {
  return std::max(box.lower.eigen().cwiseAbs().maxCoeff(), box.upper.eigen().cwiseAbs().maxCoeff());
}

/// The same of points and sites. `measured`: see measured_domain().
template <class Scalar>
double largest_coordinate(const Problem<Scalar>& problem, const Domain& measured,
                          const Box& bounding_box) {
  double largest =
      largest_coordinate(measured.is_partly_periodic() ? measured.box() : bounding_box);
  const Columns<Scalar>& fixed = problem.fixed_sites();
  if (fixed.size() > 0) largest = std::max(largest, double{fixed.eigen().cwiseAbs().maxCoeff()});
  return largest;
}

}  // namespace ccvt
