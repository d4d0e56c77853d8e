#pragma once

#include <span>

#include "ccvt/metrics.h"
#include "parallel/arena.h"

namespace ccvt {

/// Throws InvalidInput where a set has no points, since it was moved from.
inline void require_points(const PointSet& set) {
  if (set.count() == 0) throw InvalidInput("set: was moved from");
}

/// Throws InvalidInput unless there is a set and all agree in dimension, count and domain.
void check_alike(std::span<const PointSet> sets);

/// The coordinates of one point after the other.
inline std::span<const double> coordinates_of(const PointSet& set) {
  const auto& points = set.points();
  return {points.data(), points.data() + points.size()};
}

/// The points in the unit cube.
inline Points<double> in_unit_cube(const PointSet& set) {
  const Box& box = set.domain().box();
  const Eigen::ArrayXd extent = box.extent();
  return (set.points().colwise() - box.lower.eigen()).array().colwise() / extent;
}

/// Throws InvalidInput for the first option out of range.
void check_options(const SpectrumOptions& options);

/// Of radius r >= 0: V_D = V_{D-2} 2 pi r^2 / D. Not by std::lgamma(), which writes a global
/// variable.
double ball_volume(int dimension, double r);

// The metrics of analyze(), in an arena that may throw Stopped.
NearestDistances nearest_distances(const PointSet& set, const Arena& arena);
PairCorrelation pair_correlation(std::span<const PointSet> sets, const Arena& arena);
BondOrder bond_order(const PointSet& set, const Arena& arena);
Spectrum power_spectrum(std::span<const PointSet> sets, const SpectrumOptions& options,
                        const Arena& arena);
double star_discrepancy(const PointSet& set, const Arena& arena);
IntegrationVariance integration_variance(const PointSet& set, std::uint64_t seed,
                                         const Arena& arena);

}  // namespace ccvt
