#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>
#include <vector>

#include "ccvt/weighted.h"
#include "random.h"
#include "support/oracle.h"

/// What a tessellation of points with masses must be, written from weighted.h, without the
/// library's own code: all cells, all pairs of cells, all moves and exchanges of single points.
namespace ccvt::test {

enum class Masses { equal, even, heavy_tailed, whole_numbers };

/// Of a heavy tail, cut off at `most`.
inline std::vector<double> make_masses(Masses kind, Index count, double most = 1e9,
                                       std::uint64_t seed = 1) {
  ccvt::Random random(seed, 5);
  std::vector<double> masses;
  for (Index p = 0; p < count; ++p) {
    const double u = 1 - random.uniform();
    masses.push_back(kind == Masses::equal           ? 0.1
                     : kind == Masses::even          ? 0.5 + u
                     : kind == Masses::whole_numbers ? std::ceil(4 * u)
                                                     : std::min(most, std::pow(u, -1 / 1.3)));
  }
  return masses;
}

inline Real sum_of(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), Real{0});
}

inline std::size_t at(Index k) { return static_cast<std::size_t>(k); }

/// Empty if masses, errors, sites and energy of whole points are those of the owners.
template <class Scalar>
std::string whole_faults(const Points<Scalar>& points, const std::vector<double>& masses,
                         const MassOptions& options, const MassResult<Scalar>& result) {
  const auto dimension = static_cast<int>(points.rows());
  const auto n = static_cast<Index>(result.masses.size());
  if (result.owners.size() != masses.size()) return "owners missing";
  std::vector<Real> held(at(n), 0);
  std::vector<Real> moment(at(n * dimension), 0);
  Real energy = 0;
  for (std::size_t p = 0; p < masses.size(); ++p) {
    const Index s = result.owners[p];
    if (s < 0 || s >= n) return "owner of " + std::to_string(p);
    held[at(s)] += masses[p];
    for (int d = 0; d < dimension; ++d) {
      const Real u = wrapped(options.domain,
                             static_cast<Real>(points(d, static_cast<Eigen::Index>(p))) -
                                 static_cast<Real>(result.sites(d, s)),
                             d);
      moment[at(s * dimension + d)] += masses[p] * u;
      energy += masses[p] * u * u;
    }
  }
  std::string wrong;
  const Real total = sum_of(masses);
  const Real heaviest = *std::max_element(masses.begin(), masses.end());
  Real largest = 0;
  for (Index s = 0; s < n; ++s) {
    const Real capacity = result.capacities[at(s)];
    const Real given = options.capacities.empty() ? total / n : options.capacities[at(s)];
    const Real error = std::abs(held[at(s)] - capacity);
    largest = std::max(largest, error);
    if (std::abs(capacity - given) > 1e-6 * given)
      wrong += "capacity of " + std::to_string(s) + " ";
    if (std::abs(held[at(s)] - result.masses[at(s)]) > 1e-12 * total) {
      wrong += "mass of " + std::to_string(s) + " ";
    }
    if (!(error < heaviest)) wrong += "bound of " + std::to_string(s) + " ";
    const Real allowed = 64 * std::numeric_limits<Scalar>::epsilon() * (1 + std::sqrt(dimension));
    for (int d = 0; d < dimension; ++d) {
      if (std::abs(moment[at(s * dimension + d)]) > 16 * allowed * held[at(s)]) {
        wrong += "centre of " + std::to_string(s) + " ";
      }
    }
  }
  if (std::abs(largest - result.largest_mass_error) > 1e-12 * total) wrong += "largest error ";
  if (result.mass_error_bound != static_cast<double>(heaviest)) wrong += "bound ";
  if (std::abs(energy - result.summary.energy) > 1e-5 * energy + 1e-9) wrong += "energy ";
  return wrong;
}

/// What a pair may do, and what that saves: see tessellate_masses().
struct PairOracle {
  struct Point {
    Real key;
    double mass;
    bool in_first;
  };
  std::vector<Point> points;
  Real first_error, low, high, reach = 0;

  PairOracle(const Points<double>& all, const std::vector<double>& masses, const Domain& domain,
             const MassResult<double>& result, Index i, Index j)
      : first_error(result.masses[at(i)] - result.capacities[at(i)]) {
    const auto dimension = static_cast<int>(all.rows());
    for (std::size_t p = 0; p < masses.size(); ++p) {
      const Index owner = result.owners[p];
      if ((owner != i && owner != j) || masses[p] == 0) continue;
      const double* const x = all.col(static_cast<Eigen::Index>(p)).data();
      const Real to_first = squared_distance(domain, dimension, x, result.sites.col(i).data());
      const Real to_second = squared_distance(domain, dimension, x, result.sites.col(j).data());
      points.push_back({to_first - to_second, masses[p], owner == i});
      reach += masses[p] * (to_first + to_second);
    }
    const Real second = result.masses[at(j)] - result.capacities[at(j)];
    const Real middle = (first_error + second) / 2;
    Real mass = 0;
    for (const Point& point : points) mass += point.mass;
    const Real slack = 0.5L * mass / static_cast<Real>(points.size());
    const Real largest = std::max({std::abs(first_error), std::abs(second), slack});
    const Real room =
        std::max(std::abs(first_error - middle), std::min(slack, largest - std::abs(middle)));
    const Real heaviest = *std::max_element(masses.begin(), masses.end()) * (1 - 1e-9L);
    low = std::max({middle - room, -heaviest, 2 * middle - heaviest});
    high = std::min({middle + room, heaviest, 2 * middle + heaviest});
  }

  /// The most that a cut of the points no heavier than that saves.
  [[nodiscard]] Real best_cut(double heaviest) const {
    std::vector<Point> light;
    for (const Point& point : points) {
      if (point.mass <= heaviest) light.push_back(point);
    }
    std::stable_sort(light.begin(), light.end(),
                     [](const Point& a, const Point& b) { return a.key < b.key; });
    Real best = 0;
    for (std::size_t place = 0; place <= light.size(); ++place) {
      Real error = first_error;
      Real gain = 0;
      for (std::size_t k = 0; k < light.size(); ++k) {
        if (light[k].in_first == (k < place)) continue;
        error += light[k].in_first ? -light[k].mass : light[k].mass;
        gain += light[k].in_first ? light[k].mass * light[k].key : -light[k].mass * light[k].key;
      }
      if (error >= low && error <= high) best = std::max(best, gain);
    }
    return best;
  }
  [[nodiscard]] Real best_exchange() const {
    Real best = 0;
    const auto try_one = [&](const Point* a, const Point* b) {
      const Real change = (b != nullptr ? b->mass : 0) - (a != nullptr ? a->mass : 0);
      const Real gain =
          (a != nullptr ? a->mass * a->key : 0) - (b != nullptr ? b->mass * b->key : 0);
      if (first_error + change >= low && first_error + change <= high) best = std::max(best, gain);
    };
    for (const Point& a : points) {
      if (!a.in_first) {
        try_one(nullptr, &a);
        continue;
      }
      try_one(&a, nullptr);
      for (const Point& b : points) {
        if (!b.in_first) try_one(&a, &b);
      }
    }
    return best;
  }
};

/// Empty if no pair whose spheres meet has anything left to do.
inline std::string stability_faults(const Points<double>& points, const std::vector<double>& masses,
                                    const Domain& domain, const MassResult<double>& result) {
  const auto n = static_cast<Index>(result.masses.size());
  const auto dimension = static_cast<int>(points.rows());
  std::vector<Real> radius(at(n), 0);
  for (std::size_t p = 0; p < masses.size(); ++p) {
    if (masses[p] == 0) continue;
    const Index s = result.owners[p];
    radius[at(s)] = std::max(
        radius[at(s)], std::sqrt(squared_distance(domain, dimension,
                                                  points.col(static_cast<Eigen::Index>(p)).data(),
                                                  result.sites.col(s).data())));
  }
  for (Index i = 0; i < n; ++i) {
    for (Index j = i + 1; j < n; ++j) {
      const Real distance = std::sqrt(squared_distance(
          domain, dimension, result.sites.col(i).data(), result.sites.col(j).data()));
      if (distance > radius[at(i)] + radius[at(j)]) continue;
      const PairOracle pair(points, masses, domain, result, i, j);
      const Real allowed = 1e-11L * pair.reach;
      const std::string name = std::to_string(i) + " and " + std::to_string(j);
      if (pair.best_cut(1e300) > allowed) return "a cut of " + name;
      if (pair.best_cut(static_cast<double>(pair.high - pair.low) * (1 + 1e-9)) > allowed) {
        return "a light cut of " + name;
      }
      if (pair.best_exchange() > allowed) return "an exchange of " + name;
    }
  }
  return "";
}

/// Empty if one is what the other is.
template <class Scalar>
std::string mass_differences(const MassResult<Scalar>& a, const MassResult<Scalar>& b) {
  std::string wrong;
  if (!(a.sites == b.sites)) wrong += "sites ";
  if (a.owners != b.owners) wrong += "owners ";
  if (a.masses != b.masses) wrong += "masses ";
  if (a.summary.energy != b.summary.energy) wrong += "energy ";
  if (a.summary.iterations != b.summary.iterations) wrong += "iterations ";
  if (a.summary.exchanged != b.summary.exchanged) wrong += "exchanged ";
  if (a.shares.size() != b.shares.size()) wrong += "shares ";
  for (std::size_t k = 0; k < std::min(a.shares.size(), b.shares.size()); ++k) {
    if (a.shares[k].site != b.shares[k].site || a.shares[k].mass != b.shares[k].mass) {
      return wrong + "share " + std::to_string(k);
    }
  }
  return wrong;
}

}  // namespace ccvt::test
