#include "relax/update.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/keys.h"
#include "kernels/streams.h"
#include "parallel/loops.h"
#include "rounding.h"

namespace ccvt {
namespace {

using Range = kernels::Range<double>;

template <class Scalar>
Range range(const Scalar* stream, Index count) {
  const auto [low, high] = kernels::range(stream, count);
  return {low, high};
}

/// The range of the shortest differences on a torus to the stream's first coordinate.
template <class Scalar>
Range wrapped_range(const Metric& metric, const Scalar* stream, Index count, int d) {
  const Metric::Unrolled frame = metric.unrolled(*stream, d);
  const auto origin = static_cast<Scalar>(frame.origin);
  const auto turn = static_cast<Scalar>(frame.turn);
  const auto extent = static_cast<Scalar>(metric.extent()[d]);
  const Scalar one = 1;
  const kernels::WrappedCut<Scalar> cut{&origin, &one, &turn, &extent};
  const auto [high, low] = kernels::key_extremes(stream, count, cut, stream, count, cut, 1);
  return {low, high};
}

/// Whether no point of the cell is nearer to another image of `site`.
template <class Scalar>
bool is_compact(const Metric& metric, const Cells<Scalar>& cells, const double* position,
                SiteNumber site) {
  const Index count = cells.size(site);
  const Scalar* stream = cells.block(site);
  for (int d = 0; d < metric.dimension(); ++d, stream += count) {
    const auto [low, high] = range(stream, count);
    const double half = metric.extent()[d] / 2;
    if (high - position[d] > half || position[d] - low > half) return false;
  }
  return true;
}

enum class Size { small, small_across_faces, large };

/// Whether, along dimension d, a ball neither crosses the box's faces nor is too large for what is
/// said below.
bool ball_is_small(const Metric& metric, const double* centre, double radius, int d) {
  return radius <= 0.24 * metric.extent()[d] && !metric.reaches_face(centre[d], radius, d);
}

/// Whether the cell is so small that the shortest differences between its points are differences
/// in one frame. Then its centroid is the mean in that frame: the energy around a mean is half the
/// mean squared distance of all pairs of points, and no choice of images makes any of these
/// shorter. The bound leaves room for rounding.
template <class Scalar>
Size size_on_torus(const Metric& metric, const Cells<Scalar>& cells, const SiteState& sites,
                   SiteNumber site) {
  const double radius = sites.radius[site];
  const Index count = cells.size(site);
  const Scalar* stream = cells.block(site);
  Size size = Size::small;
  for (int d = 0; d < metric.dimension(); ++d, stream += count) {
    if (ball_is_small(metric, sites.at(site), radius, d)) continue;
    const double extent = metric.extent()[d];
    const auto is_narrow = [extent](const Range& r) { return r.high - r.low < extent * 0.49; };
    if (is_narrow(range(stream, count))) continue;
    size = Size::small_across_faces;
    if (!is_narrow(wrapped_range(metric, stream, count, d))) return Size::large;
  }
  return size;
}

/// One move of a site to the centroid of its points' nearest images. Returns whether that made
/// other images nearest. `spread` is measured around the new position.
template <class Scalar>
bool move_wrapped(const Metric& metric, const Cells<Scalar>& cells, double* position,
                  SiteNumber site, kernels::Spread& spread) {
  const Index count = cells.size(site);
  std::vector<double> squared_distances(cells.points(site).size(), 0.0);
  double* const squared = squared_distances.data();
  bool changed = false;
  const Scalar* stream = cells.block(site);
  for (int d = 0; d < metric.dimension(); ++d, stream += count) {
    const double old = position[d];
    double sum = 0;
    for (Index k = 0; k < count; ++k) sum += metric.wrap(stream[k] - old, d);
    const double shift = sum / count;
    position[d] = metric.into_box(old + shift, d);
    for (Index k = 0; k < count; ++k) {
      const double x = stream[k];
      const double before = metric.wrap(x - old, d);
      const double after = metric.wrap(x - position[d], d);
      changed = changed || std::abs(before - shift - after) > metric.extent()[d] / 2;
      squared[k] += after * after;
    }
  }
  spread = {0, 0};
  for (const double s : squared_distances) {
    spread.energy += s;
    spread.squared_radius = std::max(spread.squared_radius, s);
  }
  return changed;
}

/// Measures the cell of a site that stays where it is.
template <class Scalar>
kernels::Spread measure(const Metric& metric, const Cells<Scalar>& cells, SiteState& sites,
                        SiteNumber site) {
  const double* const position = sites.at(site);
  const bool compact = !metric.periodic() || is_compact(metric, cells, position, site);
  sites.compact[site] = compact ? 1 : 0;
  return kernels::spread_around(cells.block(site), cells.size(site), metric.dimension(), position,
                                compact ? nullptr : metric.extent());
}

/// Moves a site to the centroid of its cell, and measures that.
template <class Scalar>
kernels::Spread move_site(const Metric& metric, const Cells<Scalar>& cells, SiteState& sites,
                          SiteNumber site) {
  const int dimension = metric.dimension();
  const Index count = cells.size(site);
  double* position = sites.at(site);
  kernels::Spread spread{0, 0};
  const Size size = metric.periodic() ? size_on_torus(metric, cells, sites, site) : Size::small;
  if (size == Size::large) {
    double energy = std::numeric_limits<double>::infinity();
    while (move_wrapped(metric, cells, position, site, spread) && spread.energy < energy) {
      energy = spread.energy;
    }
    sites.compact[site] = is_compact(metric, cells, position, site) ? 1 : 0;
  } else {
    const double* extent = size == Size::small ? nullptr : metric.extent();
    bool moved_over = false;  // a cell on the upper face has its site on the lower one
    const Scalar* stream = cells.block(site);
    for (int d = 0; d < dimension; ++d, stream += count) {
      // From a point of the cell: a site that is still far away would cost digits.
      const double origin = stream[0];
      const double around = extent != nullptr ? extent[d] : 0;
      const double mean = origin + kernels::sum_from(stream, count, origin, around) / count;
      position[d] = metric.into_box(mean, d);
      moved_over = moved_over || position[d] != mean;
    }
    if (moved_over) extent = metric.extent();
    spread = kernels::spread_around(cells.block(site), count, dimension, position, extent);
    sites.compact[site] = extent == nullptr ? 1 : 0;
  }
  return spread;
}

}  // namespace

template <class Scalar>
void update_site(const Metric& metric, const Cells<Scalar>& cells, SiteState& sites,
                 SiteNumber site) {
  const kernels::Spread spread = sites.is_fixed(site) ? measure(metric, cells, sites, site)
                                                      : move_site(metric, cells, sites, site);
  sites.energy[site] = spread.energy;
  sites.radius[site] = upper_radius(spread.squared_radius, metric.dimension());
}

double upper_radius(double squared, int dimension) {
  return std::sqrt(squared) * (1 + (dimension + 8) * 0x1p-52);
}

double energy_of_rounding(const Metric& metric, double coordinate_bound, double points,
                          double radius) {
  const double summed =
      metric.periodic() ? (points + 16) * metric.largest_extent() : (points / 8 + 16) * 2 * radius;
  const double error = kHalfUlp * (coordinate_bound + summed);
  return points * error * error * metric.dimension();
}

double coordinate_bound_of(const Metric& metric, double all, const SiteState& sites,
                           SiteNumber site) {
  if (metric.periodic()) return all;
  double farthest = 0;
  for (std::size_t d = 0; d < sites.dimension; ++d) {
    farthest = std::max(farthest, std::abs(sites.at(site)[d]));
  }
  return std::min(all, farthest + sites.radius[site]);
}

double total_energy(const SiteState& sites, const Arena& arena) {
  constexpr std::size_t kSitesPerGrain = 1024;
  return sum_of(arena, sites.energy.size(), kSitesPerGrain,
                [&](std::size_t s) { return sites.energy[s]; });
}

template void update_site(const Metric&, const Cells<float>&, SiteState&, SiteNumber);
template void update_site(const Metric&, const Cells<double>&, SiteState&, SiteNumber);

}  // namespace ccvt
