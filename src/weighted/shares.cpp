#include "weighted/shares.h"

#include <algorithm>

#include "compensated_sum.h"
#include "parallel/loops.h"
#include "relax/nearest_sites.h"
#include "schedule/tiling.h"
#include "weighted/centre_of_mass.h"
#include "weighted/units.h"

namespace ccvt {
namespace {

constexpr std::size_t kSitesPerGrain = 64;

}  // namespace

std::vector<Index> owners_of_most(std::span<const PointNumber> units,
                                  std::span<const Index> unit_owners, std::size_t points) {
  std::vector<Index> owners(points, -1);
  for_each_divided(units, unit_owners, [&](PointNumber p, std::span<const UnitOwner> counted) {
    owners[p] = counted.front().site;
  });
  return owners;
}

template <class Scalar>
void own_by_nearest(const Metric& metric, PointsView<Scalar> points, const Box& box,
                    const SiteState& sites, const Arena& arena, std::vector<Index>& owners) {
  if (std::find(owners.begin(), owners.end(), -1) == owners.end()) return;
  const Buffer<SiteNumber> nearest =
      NearestSites<Scalar>(metric, sites, box, arena).owners(points, arena);
  for (std::size_t p = 0; p < owners.size(); ++p) {
    if (owners[p] < 0) owners[p] = nearest[p].index();
  }
}

std::vector<MassShare> shares_of(std::span<const PointNumber> units,
                                 std::span<const Index> unit_owners, std::span<const Index> owners,
                                 std::span<const double> masses) {
  std::vector<MassShare> shares;
  std::vector<std::uint8_t> divided(owners.size(), 0);
  for_each_divided(units, unit_owners, [&](PointNumber p, std::span<const UnitOwner> counted) {
    divided[p] = 1;
    Index all = 0;
    for (const UnitOwner& owner : counted) all += owner.units;
    for (const UnitOwner& owner : counted) {
      shares.push_back({p.index(), owner.site, masses[p] * owner.units / all});
    }
  });
  for (const PointNumber p : points_below(owners.size())) {
    if (divided[p] == 0 && masses[p] > 0) shares.push_back({p.index(), owners[p], masses[p]});
  }
  std::sort(shares.begin(), shares.end(), [](const MassShare& a, const MassShare& b) {
    return a.point != b.point ? a.point < b.point : a.site < b.site;
  });
  return shares;
}

template <class Scalar>
std::vector<double> move_to_shares(const Metric& metric, PointsView<Scalar> points,
                                   std::span<const MassShare> shares, const Arena& arena,
                                   SiteState& sites) {
  const Groups<MassShare> of_sites = group_by_key<MassShare>(
      arena, shares.size(), sites.count(), [&](std::size_t k) { return shares[k]; },
      [](const MassShare& share) { return SiteNumber(share.site); });
  std::vector<double> masses(sites.count(), 0.0);
  for_each_site(arena, sites.count(), kSitesPerGrain, [&](SiteNumber s) {
    const std::span<const MassShare> own = of_sites[s];
    sites.energy[s] = 0;
    if (own.empty()) return;
    CompensatedSum sum;
    for (const MassShare& share : own) sum.add(share.mass);
    masses[s] = sum.value();
    const MassSpread spread = rest_at_centre(
        metric, own, [&](const MassShare& share) { return points[share.point]; },
        [](const MassShare& share) { return share.mass; }, masses[s], sites.at(s));
    sites.energy[s] = spread.energy;
  });
  return masses;
}

template void own_by_nearest(const Metric&, PointsView<float>, const Box&, const SiteState&,
                             const Arena&, std::vector<Index>&);
template void own_by_nearest(const Metric&, PointsView<double>, const Box&, const SiteState&,
                             const Arena&, std::vector<Index>&);
template std::vector<double> move_to_shares(const Metric&, PointsView<float>,
                                            std::span<const MassShare>, const Arena&, SiteState&);
template std::vector<double> move_to_shares(const Metric&, PointsView<double>,
                                            std::span<const MassShare>, const Arena&, SiteState&);

}  // namespace ccvt
