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

// Sums are made anew:
/// when one point of so many has been exchanged,
constexpr Index kExchanged = 8;
/// when the site has moved so far, of its cell's radius, which would become too loose,
constexpr double kMoved = 0x1p-7;
/// after so many updates, and when so little of the energy is left, as it is when a point far away
/// has gone,
constexpr Index kUpdates = 32;
constexpr double kEnergyLeft = 0.5;
/// and each time where a coordinate of the site is greater than this share of the points times the
/// radius: see update_by_sums().
constexpr double kCoordinateShare = 0x1p-4;

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

template <class Scalar>
void begin_sums(Patches<Scalar>& patches, const SiteState& sites, SiteNumber site) {
  if (!patches.any()) return;
  typename Patches<Scalar>::Sums& sums = patches.sums(site);
  sums.exchanged = Patches<Scalar>::Sums::kUnknown;
  if (!patches.has(site) || sites.is_fixed(site) || sites.compact[site] == 0) return;
  sums.exchanged = 0;
  sums.updates = 0;
  sums.moved = 0;
  sums.first_energy = sums.energy = sites.energy[site];
  sums.centre.assign(sites.at(site), sites.at(site) + sites.dimension);
  sums.shift.assign(sites.dimension, 0);
}

template <class Scalar>
bool update_by_sums(const Metric& metric, Patches<Scalar>& patches, SiteState& sites,
                    SiteNumber site, Index points) {
  using Sums = typename Patches<Scalar>::Sums;
  if (!patches.any()) return false;
  Sums& sums = patches.sums(site);
  if (sums.exchanged == Sums::kUnknown || sums.exchanged > points / kExchanged ||
      sums.updates == kUpdates) {
    return false;
  }
  double* const position = sites.at(site);
  double moved = 0;
  double away = 0;
  double farthest = 0;
  for (std::size_t d = 0; d < sites.dimension; ++d) {
    const double by = sums.shift[d] / points;
    const double to = sums.centre[d] + by;
    moved += (to - position[d]) * (to - position[d]);
    away += by * by;
    farthest = std::max(farthest, std::abs(to));
  }
  const double energy = sums.energy - points * away;
  if (energy < kEnergyLeft * sums.first_energy) return false;
  if (farthest > kCoordinateShare * points * sites.radius[site]) return false;
  moved = upper_radius(moved, metric.dimension());
  const double radius = (sites.radius[site] + moved) * (1 + 4 * kHalfUlp);
  const double moved_in_all = sums.moved + moved;
  if (moved_in_all > kMoved * radius || sites.compact[site] == 0) return false;
  if (metric.periodic()) {
    for (int d = 0; d < metric.dimension(); ++d) {
      if (!ball_is_small(metric, sums.centre.data(), radius + moved_in_all, d)) return false;
    }
  }
  for (std::size_t d = 0; d < sites.dimension; ++d) {
    position[d] = sums.centre[d] + sums.shift[d] / points;
  }
  ++sums.updates;
  sums.moved = moved_in_all;
  sites.radius[site] = radius;
  sites.energy[site] = energy;
  return true;
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

template bool update_by_sums(const Metric&, Patches<float>&, SiteState&, SiteNumber, Index);
template bool update_by_sums(const Metric&, Patches<double>&, SiteState&, SiteNumber, Index);
template void begin_sums(Patches<float>&, const SiteState&, SiteNumber);
template void begin_sums(Patches<double>&, const SiteState&, SiteNumber);

}  // namespace ccvt
