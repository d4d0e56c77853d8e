#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <vector>

#include "ccvt/region.h"
#include "numbers.h"
#include "parallel/loops.h"

namespace ccvt {

/// Moves each of `sites` sites that is outside, outside(site), to the nearest of its own points: of
/// several, to the first; move(site, point). A site that owns none stays where it is.
/// `squared_distance(point, site)`. O(#owners).
template <class Outside, class SquaredDistance, class Move>
PutBack put_back_sites(std::span<const Index> owners, std::size_t sites, const Arena& arena,
                       Outside outside, SquaredDistance squared_distance, Move move) {
  constexpr std::size_t kPointsPerGrain = std::size_t{1} << 14;
  constexpr double unset = std::numeric_limits<double>::infinity();
  PutBack result;
  std::vector<double> least(sites, -unset);  // squared distances, of sites that must move
  bool all_inside = true;
  for (const SiteNumber s : sites_below(sites)) {
    if (!outside(s)) continue;
    least[s] = unset;
    all_inside = false;
  }
  if (all_inside) return result;
  const Buffer<PointNumber> theirs = collect<PointNumber>(
      arena, owners.size(), kPointsPerGrain,
      [&](std::size_t begin, std::size_t end, std::vector<PointNumber>& out, int) {
        for (std::size_t p = begin; p < end; ++p) {
          if (least[SiteNumber(owners[p])] >= 0) out.emplace_back(p);
        }
      });
  std::vector<PointNumber> nearest(sites);
  for (const PointNumber p : theirs) {
    const SiteNumber owner(owners[p]);
    const double squared = squared_distance(p, owner);
    if (!(squared < least[owner])) continue;
    least[owner] = squared;
    nearest[owner] = p;
  }
  for (const SiteNumber s : sites_below(sites)) {
    if (!(least[s] < unset && least[s] >= 0)) continue;
    move(s, nearest[s]);
    ++result.sites;
    result.farthest = std::max(result.farthest, std::sqrt(least[s]));
  }
  return result;
}

}  // namespace ccvt
