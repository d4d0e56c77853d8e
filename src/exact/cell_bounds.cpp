#include "exact/cell_bounds.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "exact/distances.h"
#include "exact/site_steps.h"
#include "kernels/bounds.h"
#include "parallel/loops.h"

namespace ccvt {
namespace {

/// n^2 at most: 256 MB.
constexpr std::size_t kMostPairs = std::size_t{1} << 25;
/// With no more points that come to a cell than this, one at a time costs less than a product.
constexpr std::size_t kFewPoints = 4;
/// Cells whose bounds follow steps together.
constexpr std::size_t kCellsAtOnce = 24;
/// Sites that are looked at together.
constexpr std::size_t kNearAtOnce = 256;
constexpr double kNone = std::numeric_limits<double>::infinity();

}  // namespace

bool CellBounds::fit(const Metric& metric, std::size_t sites) {
  return !metric.periodic() && sites * sites <= kMostPairs;
}

CellBounds::CellBounds(std::size_t points, std::size_t sites, const RankTurns& turns)
    : turns_(turns),
      bounds_((turns.place_of(sites) + 1) * sites),
      radius_(sites),
      own_costs_(points),
      covered_(points, kNowhere) {}

void CellBounds::forget(std::span<const double> sites) {
  valid_ = false;
  std::fill(covered_.begin(), covered_.end(), kNowhere);
  std::fill(bounds_.begin(), bounds_.end(), kNone);
  std::fill(radius_.begin(), radius_.end(), 0.0);
  sites_.assign(sites.begin(), sites.end());
  dimension_ = static_cast<int>(sites.size() / count());
}

void CellBounds::set(SiteNumber site, SiteNumber other, double cost) {
  if (!has(site)) return;
  const double rounding = std::abs(cost) + 2 * radius_[site] * radius_[site];
  of(site)[other] = cost - rounding_share(dimension_) * rounding - underflow_of(dimension_);
}

void CellBounds::raise(SiteNumber site, std::span<const double> least) {
  const std::span<double> bounds = of(site);
  std::transform(bounds.begin(), bounds.end(), least.begin(), bounds.begin(),
                 [](double a, double b) { return std::max(a, b); });
}

void CellBounds::select(SiteNumber site, std::span<const double> weights,
                        std::vector<SiteNumber>& near) const {
  near.clear();
  for_near(site, weights, [&](SiteNumber j) {
    near.push_back(j);
    return true;
  });
}

bool CellBounds::any_near(SiteNumber site, std::span<const double> weights) const {
  bool any = false;
  for_near(site, weights, [&](SiteNumber) {
    any = true;
    return false;
  });
  return any;
}

/// Calls visit(j) for each site that select() gives, until it returns false.
template <class Visit>
void CellBounds::for_near(SiteNumber site, std::span<const double> weights,
                          const Visit& visit) const {
  const std::span<const double> bounds = of(site);
  std::array<Index, kNearAtOnce> found{};
  for (std::size_t first = 0; first < count(); first += kNearAtOnce) {
    const auto some = static_cast<Index>(std::min(kNearAtOnce, count() - first));
    const Index number = kernels::bounds_within(bounds.data() + first, weights.data() + first,
                                                weights[site], some, found.data());
    for (const Index k : std::span(found).first(static_cast<std::size_t>(number))) {
      const SiteNumber j(static_cast<std::ptrdiff_t>(first) + k);
      if (j != site && !visit(j)) return;
    }
  }
}

/// Moves a site; returns by how much |p - site|^2 grows at most over its members.
template <class Scalar>
double CellBounds::step(SiteNumber site, const double* to, std::span<const PointNumber> members,
                        PointsView<Scalar> points, std::vector<double>& squared) {
  squared_distances(points, members, to, squared);
  const double share = rounding_share(dimension_);
  const double underflow = underflow_of(dimension_);
  double growth = -kNone;
  double farthest = 0;
  for (std::size_t k = 0; k < members.size(); ++k) {
    double& own = own_costs_[members[k]];
    growth = std::max(growth, squared[k] - own + share * (squared[k] + own));
    farthest = std::max(farthest, squared[k]);
    own = squared[k];
  }
  radius_[site] = std::sqrt(farthest + underflow) * (1 + share);
  return growth + underflow;
}

template <class Scalar>
void CellBounds::follow(std::span<const double> sites, const Grouping& groups,
                        PointsView<Scalar> points, const Arena& arena) {
  valid_ = false;
  const auto dimension = static_cast<std::size_t>(dimension_);
  const SiteSteps steps(sites_, sites, dimension, arena);
  if (steps.none()) return;
  std::vector<SiteNumber> cells;
  for (const SiteNumber s : sites_below(count())) {
    if (!has(s)) continue;
    if (groups.of(s).empty()) {
      std::fill(of(s).begin(), of(s).end(), kNone);
      radius_[s] = 0;
    } else {
      cells.push_back(s);
    }
  }
  std::vector<SiteSteps::Cell> followed(cells.size());
  PerWorker<std::vector<double>> squared(arena);
  arena.for_ranges(cells.size(), 4, [&](std::size_t begin, std::size_t end, int worker) {
    for (std::size_t k = begin; k < end; ++k) {
      arena.check();
      const SiteNumber s = cells[k];
      const double* const at = sites.data() + s * dimension;
      const double growth = steps.moved(s) ? step(s, at, groups.of(s), points, squared[worker]) : 0;
      if (!steps.all()) lower(s, growth);
      followed[k] = {at, radius_[s], growth, of(s).data()};
    }
  });
  PerWorker<SiteSteps::Scratch> scratch(arena);
  arena.for_ranges(cells.size(), kCellsAtOnce, [&](std::size_t begin, std::size_t end, int worker) {
    steps.follow(std::span(followed).subspan(begin, end - begin), scratch[worker]);
  });
  sites_.assign(sites.begin(), sites.end());
}

/// All bounds of a cell.
void CellBounds::lower(SiteNumber site, double growth) {
  if (growth == 0) return;
  for (double& bound : of(site)) {
    bound -= growth + 1e-15 * (std::abs(bound) + std::abs(growth));
  }
}

void CellBounds::widen(SiteNumber site, double own) {
  const double farthest = std::sqrt(own + underflow_of(dimension_));
  radius_[site] = std::max(radius_[site], farthest * (1 + rounding_share(dimension_)));
}

void CellBounds::include(SiteNumber site, PointNumber point, std::span<const double> squared,
                         double own) {
  if (!has(site)) return;
  covered_[point] = site.index();
  own_costs_[point] = own;
  widen(site, own);
  const double share = rounding_share(dimension_);
  const std::span<double> bounds = of(site);
  for (std::size_t j = 0; j < count(); ++j) {
    const double rounding = share * (squared[j] + own) + underflow_of(dimension_);
    bounds[j] = std::min(bounds[j], squared[j] - own - rounding);
  }
}

std::span<const double> CellBounds::include(SiteNumber site, std::span<const PointNumber> members,
                                            const MoveCosts& costs, MoveCosts::Scratch& scratch) {
  std::vector<PointNumber> came;
  for (const PointNumber p : members) {
    if (covered_[p] != site.index()) came.push_back(p);
  }
  if (came.size() <= kFewPoints) {
    for (const PointNumber p : came) {
      costs.squared({&p, 1}, site, scratch.own);
      include(site, p, costs.squared_at_least_to_all(p, scratch), scratch.own.front());
    }
    return of(site);
  }
  const std::span<const double> least = costs.bounds(site, came, scratch);
  const std::span<double> bounds = of(site);
  for (std::size_t j = 0; j < count(); ++j) bounds[j] = std::min(bounds[j], least[j]);
  radius_[site] = std::max(radius_[site], scratch.radius);
  count_in(site, came, costs, scratch);
  return bounds;
}

/// Points that its bounds count from now on.
void CellBounds::count_in(SiteNumber site, std::span<const PointNumber> points,
                          const MoveCosts& costs, MoveCosts::Scratch& scratch) {
  costs.squared(points, site, scratch.own);
  for (std::size_t k = 0; k < points.size(); ++k) {
    covered_[points[k]] = site.index();
    own_costs_[points[k]] = scratch.own[k];
  }
}

void CellBounds::set_all(const std::vector<Index>& owners, const MoveCosts& costs,
                         const Arena& arena) {
  valid_ = false;
  const Grouping groups(owners, count(), arena);
  PerWorker<MoveCosts::Scratch> scratch(arena);
  arena.for_ranges(count(), 4, [&](std::size_t begin, std::size_t end, int worker) {
    for (const SiteNumber s : sites_between(begin, end)) {
      const auto members = groups.of(s);
      if (members.empty() || !has(s)) continue;
      arena.check();
      const auto least = costs.bounds(s, members, scratch[worker]);
      std::copy(least.begin(), least.end(), of(s).begin());
      radius_[s] = scratch[worker].radius;
      count_in(s, members, costs, scratch[worker]);
    }
  });
}

void CellBounds::include_all(const std::vector<Index>& owners, const MoveCosts& costs,
                             const Arena& arena) {
  const Grouping groups(owners, count(), arena);
  PerWorker<MoveCosts::Scratch> scratch(arena);
  arena.for_ranges(count(), 4, [&](std::size_t begin, std::size_t end, int worker) {
    for (const SiteNumber s : sites_between(begin, end)) {
      arena.check();
      if (has(s)) {
        include(s, groups.of(s), costs, scratch[worker]);
      } else {
        for (const PointNumber p : groups.of(s)) covered_[p] = s.index();
      }
    }
  });
  valid_ = true;
}

template void CellBounds::follow(std::span<const double>, const Grouping&, PointsView<float>,
                                 const Arena&);
template void CellBounds::follow(std::span<const double>, const Grouping&, PointsView<double>,
                                 const Arena&);

}  // namespace ccvt
