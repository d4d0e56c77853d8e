#include "surface/gather.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "geometry/squares.h"
#include "numbers.h"

namespace ccvt {

namespace {

/// Of each site the group that most of its points are of; if no group has half of them, any one.
std::vector<Index> groups_of_sites(std::span<const Index> groups, std::span<const Index> owners,
                                   Index sites) {
  // A majority is what is left over when others are struck out in pairs [Boyer, Moore 1991].
  std::vector<Index> group(static_cast<std::size_t>(sites), -1);
  std::vector<Index> left(group.size(), 0);
  for (std::size_t p = 0; p < groups.size(); ++p) {
    const SiteNumber s(owners[p]);
    if (left[s] == 0) group[s] = groups[p];
    left[s] += group[s] == groups[p] ? 1 : -1;
  }
  return group;
}

/// The strays of a group; a site of it for each stray of another that such a site owns; and all of
/// its sites.
struct Exchange {
  std::vector<Index> strays;
  std::vector<Index> rooms;
  std::vector<Index> sites;
};

/// Takes the candidate that is nearest to a point out of the list; of very many, the last.
template <class Scalar>
Index take_nearest(PointsView<Scalar> points, PointsView<Scalar> sites, Index point, bool many,
                   std::vector<Index>& candidates) {
  std::size_t nearest = candidates.size() - 1;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t k = 0; !many && k < candidates.size(); ++k) {
    const double squared =
        squared_difference(points[point], sites[candidates[k]], points.dimension);
    if (!(squared < least)) continue;
    least = squared;
    nearest = k;
  }
  std::swap(candidates[nearest], candidates.back());
  const Index taken = candidates.back();
  candidates.pop_back();
  return taken;
}

}  // namespace

template <class Scalar>
void gather_groups(PointsView<Scalar> points, PointsView<Scalar> sites,
                   std::span<const Index> groups, std::vector<Index>& owners) {
  constexpr std::uint64_t kMostPairs = 10'000'000;
  const std::vector<Index> own = groups_of_sites(groups, owners, sites.count);
  const Index last = *std::max_element(groups.begin(), groups.end());
  std::vector<Exchange> exchanges(static_cast<std::size_t>(last) + 1);
  for (const PointNumber p : points_below(groups.size())) {
    const Index there = own[SiteNumber(owners[p])];
    if (there == groups[p]) continue;
    exchanges[static_cast<std::size_t>(groups[p])].strays.push_back(p.index());
    exchanges[static_cast<std::size_t>(there)].rooms.push_back(owners[p]);
  }
  for (const SiteNumber s : sites_below(sites.count)) {
    exchanges[static_cast<std::size_t>(own[s])].sites.push_back(s.index());
  }
  for (const Exchange& exchange : exchanges) {
    if (exchange.strays.size() > exchange.rooms.size() + exchange.sites.size()) return;
  }
  for (auto& [strays, rooms, all] : exchanges) {
    const bool many = std::uint64_t{strays.size()} * (rooms.size() + all.size()) > kMostPairs;
    for (const Index p : strays) {
      owners[PointNumber(p)] = take_nearest(points, sites, p, many, rooms.empty() ? all : rooms);
    }
  }
}

template void gather_groups<float>(PointsView<float>, PointsView<float>, std::span<const Index>,
                                   std::vector<Index>&);
template void gather_groups<double>(PointsView<double>, PointsView<double>, std::span<const Index>,
                                    std::vector<Index>&);

}  // namespace ccvt
