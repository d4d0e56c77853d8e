#include "thin/owners.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "geometry/metric.h"
#include "numbers.h"
#include "parallel/loops.h"
#include "spatial/site_tree.h"

namespace ccvt {
namespace {

constexpr std::size_t kPointsPerGrain = std::size_t{1} << 12;
/// Sites that are asked, nearest first: a few, then twice as many, until one does not face away.
constexpr int kFirstAsked = 16;
constexpr int kMostAsked = 1024;

}  // namespace

template <class Scalar>
bool face_away(PointsView<Scalar> lifted, Index a, Index b) {
  double product = 0;
  for (int d = lifted.dimension / 2; d < lifted.dimension; ++d) {
    product += static_cast<double>(lifted[a][d]) * static_cast<double>(lifted[b][d]);
  }
  return product < 0;
}

template <class Scalar>
std::vector<double> positions_of(PointsView<Scalar> points, std::span<const Index> chosen) {
  std::vector<double> positions;
  positions.reserve(chosen.size() * static_cast<std::size_t>(points.dimension));
  for (const Index c : chosen) {
    positions.insert(positions.end(), points[c], points[c] + points.dimension);
  }
  return positions;
}

template <class Scalar>
std::vector<Index> nearest_alike(PointsView<Scalar> lifted, Index point,
                                 std::span<const Index> chosen, const SiteTree& tree,
                                 std::size_t count) {
  const std::vector<double> at(lifted[point], lifted[point] + lifted.dimension);
  const auto most = static_cast<int>(std::min<std::size_t>(kMostAsked, chosen.size()));
  std::vector<Index> asked;
  std::vector<Index> alike;
  for (int sites = std::min(kFirstAsked, most);; sites = std::min(2 * sites, most)) {
    asked.clear();
    alike.clear();
    tree.nearest(at.data(), sites, asked);
    for (const Index site : asked) {
      if (!face_away(lifted, point, chosen[SiteNumber(site)])) alike.push_back(site);
      if (alike.size() == count) return alike;
    }
    if (sites == most) return alike;
  }
}

template <class Scalar>
std::vector<Index> nearest_chosen(PointsView<Scalar> points, std::span<const Index> chosen,
                                  const Arena& arena) {
  const Metric metric(points.dimension, Domain());
  const SiteTree tree(metric, positions_of(points, chosen));
  std::vector<Index> owners(static_cast<std::size_t>(points.count));
  arena.for_each(owners.size(), kPointsPerGrain, [&](std::size_t k) {
    const Index p = PointNumber(k).index();
    const std::vector<double> at(points[p], points[p] + points.dimension);
    owners[k] = tree.nearest(at.data());
  });
  for (std::size_t s = 0; s < chosen.size(); ++s) {
    owners[PointNumber(chosen[s])] = SiteNumber(s).index();
  }
  return owners;
}

template <class Scalar>
Index take_turned(PointsView<Scalar> lifted, std::span<const Index> chosen,
                  std::vector<Index>& owners, const Arena& arena) {
  const Buffer<PointNumber> turned = collect<PointNumber>(
      arena, owners.size(), kPointsPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<PointNumber>& out, int) {
        for (std::size_t k = begin; k < end; ++k) {
          const PointNumber p(k);
          if (face_away(lifted, p.index(), chosen[SiteNumber(owners[p])])) out.push_back(p);
        }
      });
  if (turned.empty()) return 0;
  const Metric metric(lifted.dimension, Domain());
  const SiteTree tree(metric, positions_of(lifted, chosen));
  std::vector<Index> taken(turned.size());
  constexpr std::size_t kQueriesPerGrain = 64;
  arena.for_each(turned.size(), kQueriesPerGrain, [&](std::size_t k) {
    const PointNumber p = turned[k];
    const std::vector<Index> found = nearest_alike(lifted, p.index(), chosen, tree);
    taken[k] = found.empty() ? owners[p] : found.front();
  });
  Index count = 0;
  for (std::size_t k = 0; k < taken.size(); ++k) {
    if (std::exchange(owners[turned[k]], taken[k]) != taken[k]) ++count;
  }
  return count;
}

template bool face_away(PointsView<float>, Index, Index);
template bool face_away(PointsView<double>, Index, Index);
template std::vector<Index> nearest_alike(PointsView<float>, Index, std::span<const Index>,
                                          const SiteTree&, std::size_t);
template std::vector<Index> nearest_alike(PointsView<double>, Index, std::span<const Index>,
                                          const SiteTree&, std::size_t);
template std::vector<double> positions_of(PointsView<float>, std::span<const Index>);
template std::vector<double> positions_of(PointsView<double>, std::span<const Index>);
template std::vector<Index> nearest_chosen(PointsView<float>, std::span<const Index>, const Arena&);
template std::vector<Index> nearest_chosen(PointsView<double>, std::span<const Index>,
                                           const Arena&);
template Index take_turned(PointsView<float>, std::span<const Index>, std::vector<Index>&,
                           const Arena&);
template Index take_turned(PointsView<double>, std::span<const Index>, std::vector<Index>&,
                           const Arena&);

}  // namespace ccvt
