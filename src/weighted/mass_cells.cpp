#include "weighted/mass_cells.h"

#include <algorithm>
#include <utility>

#include "compensated_sum.h"
#include "exact/grouping.h"
#include "relax/update.h"
#include "schedule/tiling.h"
#include "weighted/centre_of_mass.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = 4096;

}  // namespace

template <class Scalar>
MassCells<Scalar>::MassCells(const Metric& metric, PointsView<Scalar> points,
                             std::span<const double> masses, std::span<const double> capacities,
                             std::span<const Index> owners, SiteState sites,
                             double coordinate_bound, const Arena& arena)
    : metric_(metric),
      points_(points),
      masses_(masses),
      capacities_(capacities),
      sites_(std::move(sites)),
      coordinate_bound_(coordinate_bound),
      cells_(capacities.size()),
      held_(capacities.size(), 0.0),
      margin_(capacities.size(), 0.0) {
  for (const double mass : masses) heaviest_ = std::max(heaviest_, mass);
  const Grouping groups(owners, capacities.size());
  const std::size_t sites_per_grain = 1 + kPointsPerGrain * cells_.size() / owners.size();
  for_each_site(arena, cells_.size(), sites_per_grain, [&](SiteNumber s) {
    std::vector<PointNumber> own;
    for (const PointNumber p : groups.of(s)) {
      if (masses_[p] > 0) own.push_back(p);
    }
    set_members(s, std::move(own));
    update(s);
  });
}

template <class Scalar>
void MassCells<Scalar>::set_members(SiteNumber site, std::vector<PointNumber> members) {
  std::sort(members.begin(), members.end(),
            [&](PointNumber a, PointNumber b) { return precedes(a, b); });
  Cell& cell = cells_[site];
  const std::size_t count = members.size();
  const std::size_t width = metric_.coordinate_count();
  cell.points = std::move(members);
  cell.masses.resize(count);
  cell.coordinates.resize(count * width);
  for (std::size_t k = 0; k < count; ++k) {
    cell.masses[k] = masses_[cell.points[k]];
    const Scalar* const x = at(cell.points[k]);
    for (std::size_t d = 0; d < width; ++d) cell.coordinates[d * count + k] = x[d];
  }
  weigh(site);
}

template <class Scalar>
void MassCells<Scalar>::weigh(SiteNumber site) {
  CompensatedSum sum;
  for (const double mass : cells_[site].masses) sum.add(mass);
  held_[site] = sum.value();
}

template <class Scalar>
typename MassCells<Scalar>::Cell MassCells<Scalar>::merged(
    SiteNumber i, SiteNumber j, std::span<const std::size_t> which) const {
  const Cell& first = cells_[i];
  const Cell& second = cells_[j];
  const std::size_t own = first.points.size();
  const std::size_t others = second.points.size();
  const std::size_t count = which.size();
  Cell cell;
  cell.points.resize(count);
  cell.masses.resize(count);
  cell.coordinates.resize(count * metric_.coordinate_count());
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t from = which[k];
    cell.points[k] = from < own ? first.points[from] : second.points[from - own];
    cell.masses[k] = from < own ? first.masses[from] : second.masses[from - own];
  }
  for (std::size_t d = 0; d < metric_.coordinate_count(); ++d) {
    const Scalar* const here = first.coordinates.data() + d * own;
    const Scalar* const there = second.coordinates.data() + d * others;
    Scalar* const to = cell.coordinates.data() + d * count;
    for (std::size_t k = 0; k < count; ++k) {
      to[k] = which[k] < own ? here[which[k]] : there[which[k] - own];
    }
  }
  return cell;
}

template <class Scalar>
void MassCells<Scalar>::regroup(SiteNumber i, SiteNumber j, std::span<const std::size_t> to_first,
                                std::span<const std::size_t> to_second) {
  Cell first = merged(i, j, to_first);
  cells_[j] = merged(i, j, to_second);
  cells_[i] = std::move(first);
  weigh(i);
  weigh(j);
}

/// Where a point is among the members, or would be.
template <class Scalar>
std::size_t MassCells<Scalar>::place_in(const Cell& cell, PointNumber point) const {
  const auto found = std::lower_bound(cell.points.begin(), cell.points.end(), point,
                                      [&](PointNumber a, PointNumber b) { return precedes(a, b); });
  return static_cast<std::size_t>(found - cell.points.begin());
}

template <class Scalar>
void MassCells<Scalar>::insert(Cell& cell, PointNumber point) const {
  const std::size_t k = place_in(cell, point);
  const std::size_t count = cell.points.size();
  const auto offset = static_cast<std::ptrdiff_t>(k);
  cell.points.insert(cell.points.begin() + offset, point);
  cell.masses.insert(cell.masses.begin() + offset, masses_[point]);
  cell.coordinates.resize(metric_.coordinate_count() * (count + 1));
  // Streams make room from the last one on.
  for (std::size_t d = metric_.coordinate_count(); d-- > 0;) {
    Scalar* const before = cell.coordinates.data() + d * count;
    Scalar* const after = before + d;
    std::move_backward(before + k, before + count, after + count + 1);
    if (d > 0) std::move_backward(before, before + k, after + k);
    after[k] = at(point)[d];
  }
}

template <class Scalar>
void MassCells<Scalar>::remove(Cell& cell, PointNumber point) const {
  const std::size_t k = place_in(cell, point);
  const std::size_t count = cell.points.size();
  const auto offset = static_cast<std::ptrdiff_t>(k);
  cell.points.erase(cell.points.begin() + offset);
  cell.masses.erase(cell.masses.begin() + offset);
  for (std::size_t d = 0; d < metric_.coordinate_count(); ++d) {
    Scalar* const before = cell.coordinates.data() + d * count;
    Scalar* const after = before - d;
    if (d > 0) std::move(before, before + k, after);
    std::move(before + k + 1, before + count, after + k);
  }
  cell.coordinates.resize(metric_.coordinate_count() * (count - 1));
}

template <class Scalar>
void MassCells<Scalar>::move(PointNumber point, SiteNumber from, SiteNumber to) {
  remove(cells_[from], point);
  insert(cells_[to], point);
  weigh(from);
  weigh(to);
}

template <class Scalar>
void MassCells<Scalar>::update(SiteNumber site) {
  sites_.energy[site] = sites_.radius[site] = margin_[site] = 0;
  if (cells_[site].points.empty()) return;
  const MassSpread spread = rest_at_centre(
      metric_, cells_[site].points, [&](PointNumber p) { return at(p); },
      [&](PointNumber p) { return masses_[p]; }, held_[site], sites_.at(site));
  sites_.energy[site] = spread.energy;
  sites_.radius[site] = upper_radius(spread.squared_radius, metric_.dimension());
  const auto count = static_cast<double>(cells_[site].points.size());
  constexpr double kRounded = 4;  // of a mean of weighted points, and of where it is measured from
  margin_[site] =
      kRounded * held_[site] *
      (energy_of_rounding(metric_, coordinate_bound_, count, sites_.radius[site]) / count);
}

template <class Scalar>
std::vector<Index> MassCells<Scalar>::owners() const {
  std::vector<Index> owners(static_cast<std::size_t>(points_.count), -1);
  for (const SiteNumber s : sites_.all()) {
    for (const PointNumber p : cells_[s].points) owners[p] = s.index();
  }
  return owners;
}

template class MassCells<float>;
template class MassCells<double>;

}  // namespace ccvt
