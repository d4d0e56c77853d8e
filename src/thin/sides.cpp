#include "thin/sides.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "geometry/metric.h"
#include "numbers.h"
#include "relax/disjoint_sets.h"
#include "spatial/site_tree.h"
#include "thin/owners.h"

namespace ccvt {
namespace {

constexpr std::size_t kLinked = 6;
constexpr std::size_t kSitesPerGrain = 64;

}  // namespace

template <class Scalar>
std::vector<Side> sides_of(PointsView<Scalar> lifted, std::span<const Index> chosen,
                           const Arena& arena) {
  const Metric metric(lifted.dimension, Domain());
  const SiteTree tree(metric, positions_of(lifted, chosen));
  const PointsView<Scalar> places{lifted.data, lifted.dimension / 2, lifted.count, lifted.stride};
  const Metric metric_of_places(places.dimension, Domain());
  const SiteTree tree_of_places(metric_of_places, positions_of(places, chosen));
  const auto most = static_cast<int>(std::min(kLinked + 1, chosen.size()));
  std::vector<std::vector<Index>> near(chosen.size());
  std::vector<std::uint8_t> faced(chosen.size(), 0);  // one of the nearest sites faces away
  arena.for_each(chosen.size(), kSitesPerGrain, [&](std::size_t s) {
    near[s] = nearest_alike(lifted, chosen[s], chosen, tree, kLinked + 1);  // itself among them
    const std::vector<double> at(lifted[chosen[s]], lifted[chosen[s]] + places.dimension);
    std::vector<Index> nearest;  // normals aside
    tree_of_places.nearest(at.data(), most, nearest);
    faced[s] = std::any_of(nearest.begin(), nearest.end(), [&](Index site) {
      return face_away(lifted, chosen[s], chosen[SiteNumber(site)]);
    });
  });
  DisjointSets<SiteNumber> sets(chosen.size());
  for (const SiteNumber s : sites_below(chosen.size())) {
    for (const Index other : near[s]) sets.join(s, SiteNumber(other));
  }
  // Where nothing near faces apart, parts are one side, however far away from each other.
  std::vector<std::uint8_t> apart(chosen.size(), 0);
  for (const SiteNumber s : sites_below(chosen.size())) {
    if (faced[s] != 0) apart[sets.root(s)] = 1;
  }
  std::optional<SiteNumber> rest;
  for (const SiteNumber s : sites_below(chosen.size())) {
    if (apart[sets.root(s)] != 0) continue;
    if (!rest) rest = s;
    sets.join(*rest, s);
  }

  std::vector<Side> sides;
  std::vector<std::size_t> number(chosen.size());  // of each site's side
  for (const SiteNumber s : sites_below(chosen.size())) {
    const SiteNumber first = sets.root(s);
    if (first == s) {
      number[s] = sides.size();
      sides.emplace_back();
    }
    number[s] = number[first];
    sides[number[s]].sites.push_back(s.index());
  }
  std::vector<Index> owners = nearest_chosen(lifted, chosen, arena);
  take_turned(lifted, chosen, owners, arena);
  for (const PointNumber p : points_below(lifted.count)) {
    sides[number[SiteNumber(owners[p])]].points.push_back(p.index());
  }
  return sides;
}

template std::vector<Side> sides_of(PointsView<float>, std::span<const Index>, const Arena&);
template std::vector<Side> sides_of(PointsView<double>, std::span<const Index>, const Arena&);

}  // namespace ccvt
