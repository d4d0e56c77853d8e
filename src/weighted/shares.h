#pragma once

#include <span>
#include <vector>

#include "ccvt/weighted.h"
#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/arena.h"
#include "relax/site_state.h"

namespace ccvt {

/// Of points that have unit points: the site that owns most of them; -1 for the others.
std::vector<Index> owners_of_most(std::span<const PointNumber> units,
                                  std::span<const Index> unit_owners, std::size_t points);

/// Gives points whose owner is -1 to the nearest site.
template <class Scalar>
void own_by_nearest(const Metric& metric, PointsView<Scalar> points, const Box& box,
                    const SiteState& sites, const Arena& arena, std::vector<Index>& owners);

/// What each point's mass is divided into: for points with unit points by these, else all of it for
/// the owner. Shares without mass are left out.
std::vector<MassShare> shares_of(std::span<const PointNumber> units,
                                 std::span<const Index> unit_owners, std::span<const Index> owners,
                                 std::span<const double> masses);

/// Moves each site to the centre of mass of its shares, whose masses it returns, and sets energies.
template <class Scalar>
std::vector<double> move_to_shares(const Metric& metric, PointsView<Scalar> points,
                                   std::span<const MassShare> shares, const Arena& arena,
                                   SiteState& sites);

}  // namespace ccvt
