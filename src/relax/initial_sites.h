#pragma once

#include <cstdint>

#include "ccvt/problem.h"
#include "geometry/metric.h"
#include "parallel/arena.h"
#include "parallel/together.h"
#include "relax/site_state.h"

namespace ccvt {

/// Whether points have initial owners. Of several ranks, all call it: one may have no points.
template <class Scalar>
bool has_initial_owners(const Problem<Scalar>& problem) {
  return any(problem.ranks(), !problem.initial_owners().empty());
}

/// Where the sites of a problem start, in the caller's order: its initial sites; of initial owners
/// any point of each cell, from which the centroid update goes on; or else distinct points, each
/// set of n equally likely, in the order of the points. Fixed sites come first, where they are, and
/// take the places of the nearest sites that were drawn. O(m).
template <class Scalar>
SiteState initial_sites(const Problem<Scalar>& problem, const Metric& metric, std::uint64_t seed,
                        const Arena& arena = Arena(1));

extern template SiteState initial_sites(const Problem<float>&, const Metric&, std::uint64_t,
                                        const Arena&);
extern template SiteState initial_sites(const Problem<double>&, const Metric&, std::uint64_t,
                                        const Arena&);

}  // namespace ccvt
