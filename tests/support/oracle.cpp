#include "support/oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

namespace ccvt::test {
namespace {

constexpr Real kEpsilon = std::numeric_limits<double>::epsilon();

std::size_t at(std::int64_t i) { return static_cast<std::size_t>(i); }

/// The largest magnitude of a coordinate: the scale at which positions are rounded.
template <class Scalar>
Real coordinate_bound(const Problem<Scalar>& problem) {
  const Box box = problem.bounding_box();
  Real bound =
      std::max(box.lower.eigen().cwiseAbs().maxCoeff(), box.upper.eigen().cwiseAbs().maxCoeff());
  for (Eigen::Index s = 0; s < problem.fixed_sites().cols(); ++s) {
    bound = std::max<Real>(bound, problem.fixed_sites().col(s).cwiseAbs().maxCoeff());
  }
  return bound;
}

/// What is owed to rounding in a position that the library keeps as a double and reaches by a sum
/// of `count` differences in eight parts: half a unit at the scale of the coordinates for the
/// position itself, and one for each addition.
Real position_rounding(Real coordinates, Index count) {
  return (static_cast<Real>(count) / 8 + 16) * kEpsilon * coordinates;
}

std::vector<std::vector<Index>> cells_of(const std::vector<Index>& owners, Index sites) {
  std::vector<std::vector<Index>> cells(at(sites));
  for (std::size_t p = 0; p < owners.size(); ++p) {
    cells[at(owners[p])].push_back(static_cast<Index>(p));
  }
  return cells;
}

/// The centroid of a cell, as seen from where the library says that it is.
///
/// On a torus it is the fixed point of "the mean of the nearest images", and there may be many. A
/// point half an extent away has two nearest images; the site returned, rounded to float maybe,
/// cannot tell which one was meant, so any number of such points may be turned over.
template <class Scalar>
std::vector<Real> centroid(const Problem<Scalar>& problem, Real coordinates,
                           const std::vector<Index>& cell, const Scalar* near) {
  const auto& points = problem.points();
  const Domain& domain = problem.domain();
  const auto count = static_cast<Real>(cell.size());
  std::vector<Real> result;
  for (int d = 0; d < problem.dimension(); ++d) {
    const bool periodic = domain.has_box() && domain.is_periodic(d);
    const Real origin =
        periodic ? static_cast<Real>(near[d]) : static_cast<Real>(points[cell.front()][d]);
    const Real rounding =
        4 * static_cast<Real>(std::numeric_limits<Scalar>::epsilon()) * coordinates;
    Real sum = 0;
    Index on_the_edge = 0;
    for (const Index p : cell) {
      const Real u = wrapped(domain, static_cast<Real>(points[p][d]) - origin, d);
      sum += u;
      if (periodic && domain.box().extent()[d] / 2 - std::abs(u) < rounding) {
        ++on_the_edge;
      }
    }
    Real shift = sum / count;
    for (Index k = -on_the_edge; k <= on_the_edge && on_the_edge > 0; ++k) {
      const Real turned = (sum + k * static_cast<Real>(domain.box().extent()[d])) / count;
      if (std::abs(turned) < std::abs(shift)) shift = turned;
    }
    result.push_back(origin + shift);
  }
  return result;
}

/// The places of the fixed sites, and the centroids of the others' cells.
template <class Scalar>
std::vector<std::vector<Real>> centroids(const Problem<Scalar>& problem,
                                         const Points<Scalar>& sites,
                                         const std::vector<std::vector<Index>>& cells) {
  const Real bound = coordinate_bound(problem);
  std::vector<std::vector<Real>> result;
  for (std::size_t s = 0; s < cells.size(); ++s) {
    const auto& fixed = problem.fixed_sites();
    if (std::cmp_less(s, fixed.cols())) {
      const auto position = fixed.col(static_cast<Eigen::Index>(s));
      result.emplace_back(position.begin(), position.end());
      continue;
    }
    result.push_back(
        centroid(problem, bound, cells[s], sites.col(static_cast<Eigen::Index>(s)).data()));
  }
  return result;
}

/// How far rounded positions can throw a sum of squares `energy` of m points.
template <class Scalar>
Real energy_rounding(const Problem<Scalar>& problem, Real energy) {
  const Real m = problem.point_count();
  const auto& capacities = problem.capacities();
  const Real shift = position_rounding(coordinate_bound(problem),
                                       *std::max_element(capacities.begin(), capacities.end())) *
                     std::sqrt(static_cast<Real>(problem.dimension()));
  return 1e-13L * energy + 2 * shift * std::sqrt(m * energy) + m * shift * shift;
}

}  // namespace

Real wrapped(const Domain& domain, Real difference, int d) {
  if (!domain.has_box() || !domain.is_periodic(d)) return difference;
  const Real extent =
      static_cast<Real>(domain.box().upper[d]) - static_cast<Real>(domain.box().lower[d]);
  if (difference > extent / 2) return difference - extent;
  return difference < -extent / 2 ? difference + extent : difference;
}

template <class Scalar>
std::string ownership_faults(const Problem<Scalar>& problem, const std::vector<Index>& owners) {
  std::ostringstream wrong;
  if (owners.size() != at(problem.point_count())) {
    wrong << owners.size() << " owners for " << problem.point_count() << " points\n";
    return wrong.str();
  }
  std::vector<Index> size(problem.capacities().size(), 0);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    if (owners[p] < 0 || owners[p] >= problem.site_count()) {
      wrong << "point " << p << " has the owner " << owners[p] << '\n';
      return wrong.str();
    }
    ++size[at(owners[p])];
  }
  for (std::size_t s = 0; s < size.size(); ++s) {
    if (size[s] == problem.capacities()[s]) continue;
    wrong << "site " << s << " owns " << size[s] << " points, not " << problem.capacities()[s]
          << '\n';
  }
  return wrong.str();
}

template <class Scalar>
std::string geometry_faults(const Problem<Scalar>& problem, const Points<Scalar>& sites,
                            const std::vector<Index>& owners, const Summary& summary) {
  std::ostringstream wrong;
  const Domain& domain = problem.domain();
  const auto cells = cells_of(owners, problem.site_count());
  const auto exact = centroids(problem, sites, cells);
  const Real bound = coordinate_bound(problem);
  Real energy = 0;
  for (Index s = 0; s < problem.site_count(); ++s) {
    const auto& cell = cells[at(s)];
    for (int d = 0; d < problem.dimension(); ++d) {
      const auto given = static_cast<Real>(sites(d, s));
      const Real allowed =
          position_rounding(bound, static_cast<Index>(cell.size())) +
          static_cast<Real>(std::numeric_limits<Scalar>::epsilon()) * std::abs(given);
      if (!(std::abs(given - exact[at(s)][static_cast<std::size_t>(d)]) <= allowed)) {
        wrong << "site " << s << ": coordinate " << d << " is " << given << ", the centroid's "
              << exact[at(s)][static_cast<std::size_t>(d)] << '\n';
      }
      if (domain.has_box() && domain.is_periodic(d) &&
          !(given >= domain.box().lower[d] && given <= domain.box().upper[d])) {
        wrong << "site " << s << ": coordinate " << d << " is " << given << ": outside the box\n";
      }
    }
    for (const Index p : cell) {
      energy +=
          squared_distance(domain, problem.dimension(), problem.points()[p], exact[at(s)].data());
    }
  }
  if (!(std::abs(summary.energy - energy) <= energy_rounding(problem, energy))) {
    wrong << "the summary's energy is " << summary.energy << ", that of the cells " << energy
          << '\n';
  }
  const Box box = problem.bounding_box();
  const Real normalized = box.volume() > 0
                              ? summary.energy *
                                    std::pow(problem.site_count() / static_cast<Real>(box.volume()),
                                             2.0L / problem.dimension()) /
                                    problem.point_count()
                              : 0;
  if (!(std::abs(summary.normalized_energy - normalized) <= 1e-12L * normalized)) {
    wrong << "the normalized energy is " << summary.normalized_energy << ", not " << normalized
          << '\n';
  }
  return wrong.str();
}

template <class Scalar>
std::string descent_faults(const Problem<Scalar>& problem, const Summary& summary) {
  std::ostringstream wrong;
  const auto& log = summary.iterations_log;
  for (std::size_t k = 1; k < log.size(); ++k) {
    if (log[k].level != log[k - 1].level) continue;
    const Real before = log[k - 1].energy;
    const Real allowed = log[k].swaps == 0 ? 0 : energy_rounding(problem, before);
    if (!(log[k].energy <= before + allowed)) {
      wrong << "the energy rises in iteration " << log[k].iteration << ", from " << before << " to "
            << log[k].energy << '\n';
    }
  }
  return wrong.str();
}

template <class Scalar>
std::string stability_faults(const Problem<Scalar>& problem, const Points<Scalar>& sites,
                             const std::vector<Index>& owners) {
  std::ostringstream wrong;
  const int dimension = problem.dimension();
  const Domain& domain = problem.domain();
  const auto cells = cells_of(owners, problem.site_count());
  const auto exact = centroids(problem, sites, cells);
  const std::size_t n = cells.size();

  // worst[i][j]: the largest |p - s_i|^2 - |p - s_j|^2 over the points p of cell i.
  std::vector<Real> worst(n * n, -std::numeric_limits<Real>::infinity());
  std::vector<Real> radius(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    for (const Index p : cells[i]) {
      const Scalar* x = problem.points()[p];
      const Real own = squared_distance(domain, dimension, x, exact[i].data());
      radius[i] = std::max(radius[i], std::sqrt(own));
      for (std::size_t j = 0; j < n; ++j) {
        const Real gain = own - squared_distance(domain, dimension, x, exact[j].data());
        worst[i * n + j] = std::max(worst[i * n + j], gain);
      }
    }
  }
  // The library decides in double, from sites that are rounded: a gain of the order of
  // eps * reach * (reach + coordinates), with a factor for the additions over the dimensions and
  // over the cells, is a tie to it. `reach` bounds every distance between points and sites of the
  // two cells. Anything it misses beyond that is a fault.
  const Real scale = coordinate_bound(problem);
  const Real extent =
      domain.is_periodic() ? static_cast<Real>(domain.box().extent().maxCoeff()) : 0;
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      const Real reach =
          radius[i] + radius[j] +
          std::sqrt(squared_distance(domain, dimension, exact[i].data(), exact[j].data()));
      const Real sizes = static_cast<Real>(cells[i].size() + cells[j].size());
      const Real shift = (sizes / 8 + 32) * kEpsilon * scale;
      const Real allowed = 16 * (dimension + 4) * kEpsilon * reach * (reach + extent) +
                           4 * shift * reach + dimension * sizes * shift * shift;
      const Real gain = worst[i * n + j] + worst[j * n + i];
      if (!(gain <= allowed)) {
        wrong << "sites " << i << " and " << j << ": an exchange gains " << gain
              << " (rounding: " << allowed << ")\n";
      }
    }
  }
  return wrong.str();
}

#define CCVT_INSTANTIATE(Scalar)                                                            \
  template std::string ownership_faults(const Problem<Scalar>&, const std::vector<Index>&); \
  template std::string geometry_faults(const Problem<Scalar>&, const Points<Scalar>&,       \
                                       const std::vector<Index>&, const Summary&);          \
  template std::string descent_faults(const Problem<Scalar>&, const Summary&);              \
  template std::string stability_faults(const Problem<Scalar>&, const Points<Scalar>&,      \
                                        const std::vector<Index>&);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt::test
