#include "torn/mend.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <utility>
#include <vector>

#include "exact/assignment.h"
#include "exact/centroids.h"
#include "exact/grouping.h"
#include "parallel/together.h"

namespace ccvt {
namespace {

/// Rounds of assigning and of moving sites end when one gains no more than the one share, for pairs
/// do what is left sooner. When the first gains no more than the other, all stays as it was.
constexpr double kLeastGain = 5e-3;
constexpr double kLeastFirstGain = 2e-3;
constexpr int kMostRounds = 32;

/// The sum of squared distances of points to these sites.
template <class Scalar>
double energy_of(const Metric& metric, const PointsView<Scalar>& points,
                 const std::vector<double>& sites, const std::vector<Index>& owner) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  double energy = 0;
  for (Index p = 0; p < points.count; ++p) {
    const auto site = static_cast<std::size_t>(owner[static_cast<std::size_t>(p)]);
    energy += metric.squared_distance(points[p], &sites[site * dimension]);
  }
  return energy;
}

}  // namespace

template <class Scalar>
double mend(const Metric& metric, const Window& window, LevelState<Scalar>& state,
            const Arena& arena, std::vector<Unmended<Scalar>>& undo) {
  const std::size_t dimension = state.sites.dimension;
  std::vector<PointOfAll> number;
  std::vector<Scalar> coordinates;
  std::vector<Index> capacities;
  std::vector<Index> owner;
  std::vector<double> sites;
  for (std::size_t k = 0; k < window.size(); ++k) {
    const SiteNumber s = window[k];
    capacities.push_back(state.cells.size(s));
    owner.insert(owner.end(), static_cast<std::size_t>(capacities.back()), static_cast<Index>(k));
    sites.insert(sites.end(), state.sites.at(s), state.sites.at(s) + dimension);
    if (!state.tiling.is_own(state.tiling.tile_of(s))) continue;
    for (Index place = 0; place < capacities.back(); ++place) {
      number.push_back(state.cells.point(s, place));
      coordinates.resize(coordinates.size() + dimension);
      state.cells.get(s, place, &coordinates[coordinates.size() - dimension]);
    }
  }
  Unmended<Scalar> before_all{window, number, coordinates, sites, {}, {}};
  for (const SiteNumber s : window) {
    before_all.radius.push_back(state.sites.radius[s]);
    before_all.energy.push_back(state.sites.energy[s]);
  }
  number = joined(state.tiling.ranks(), std::move(number));
  coordinates = joined(state.tiling.ranks(), std::move(coordinates));
  const PointsView<Scalar> points{coordinates.data(), static_cast<int>(dimension),
                                  static_cast<Index>(number.size()),
                                  static_cast<std::ptrdiff_t>(dimension)};

  std::vector<double> prices(window.size(), 0.0);
  ExactAssignment<Scalar> assignment(metric, points, static_cast<Index>(window.size()), capacities,
                                     arena);
  const double energy_before = energy_of(metric, points, sites, owner);
  double energy = energy_before;
  for (int round = 0; round < kMostRounds; ++round) {
    assignment.improve(sites, prices, owner);
    const double before = std::exchange(energy, energy_of(metric, points, sites, owner));
    const double gain = (before - energy) / before;
    if (round == 0 && !(gain >= kLeastFirstGain)) return 0;
    move_to_centroids(metric, points, Grouping(owner, prices.size()), arena, sites);
    for (std::size_t k = 0; k < window.size(); ++k) {
      if (state.sites.is_fixed(window[k])) {
        std::copy_n(state.sites.at(window[k]), dimension, &sites[k * dimension]);
      }
    }
    if (!(gain >= kLeastGain)) break;  // nor where nothing costs anything
  }

  undo.push_back(std::move(before_all));
  for (std::size_t k = 0; k < window.size(); ++k) {
    std::copy_n(&sites[k * dimension], dimension, state.sites.at(window[k]));
    state.sites.radius[window[k]] = std::numeric_limits<double>::infinity();
    state.sites.energy[window[k]] = 0;
  }
  std::vector<Index> filled(window.size(), 0);
  double energy_after = 0;
  for (std::size_t p = 0; p < owner.size(); ++p) {
    const SiteNumber s = window[static_cast<std::size_t>(owner[p])];
    const Scalar* x = points[static_cast<Index>(p)];
    const double cost = metric.squared_distance(x, state.sites.at(s));
    state.sites.energy[s] += cost;
    energy_after += cost;
    const Index place = filled[static_cast<std::size_t>(owner[p])]++;
    if (state.tiling.is_own(state.tiling.tile_of(s))) state.cells.put(s, place, number[p], x);
  }
  return energy_before - energy_after;
}

template <class Scalar>
void restore(std::vector<Unmended<Scalar>>& undo, LevelState<Scalar>& state) {
  const std::size_t dimension = state.sites.dimension;
  for (; !undo.empty(); undo.pop_back()) {
    const Unmended<Scalar>& old = undo.back();
    std::size_t p = 0;
    for (std::size_t k = 0; k < old.window.size(); ++k) {
      const SiteNumber s = old.window[k];
      std::copy_n(&old.sites[k * dimension], dimension, state.sites.at(s));
      state.sites.radius[s] = old.radius[k];
      state.sites.energy[s] = old.energy[k];
      if (!state.tiling.is_own(state.tiling.tile_of(s))) continue;
      for (Index place = 0; place < state.cells.size(s); ++place, ++p) {
        state.cells.put(s, place, old.number[p], &old.coordinates[p * dimension]);
      }
    }
  }
}

#define CCVT_INSTANTIATE(Scalar)                                                        \
  template double mend(const Metric&, const Window&, LevelState<Scalar>&, const Arena&, \
                       std::vector<Unmended<Scalar>>&);                                 \
  template void restore(std::vector<Unmended<Scalar>>&, LevelState<Scalar>&);

CCVT_INSTANTIATE(float)
CCVT_INSTANTIATE(double)
#undef CCVT_INSTANTIATE

}  // namespace ccvt
