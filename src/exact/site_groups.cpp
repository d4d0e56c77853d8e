#include "exact/site_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "exact/distances.h"
#include "exact/packs.h"
#include "geometry/squares.h"
#include "kernels/nearest.h"

namespace ccvt {

SiteGroups::SiteGroups(const WeightedSites& sites, std::size_t most, const Arena& arena)
    : near(sites.position, sites.dimension, most, arena),
      centres(near.means(sites.position, sites.dimension)),
      weight(near.count(), -std::numeric_limits<double>::infinity()),
      dimension_(static_cast<int>(sites.dimension)),
      packs_(packs_of(centres, sites.dimension)),
      radius_(near.count(), 0.0) {
  rows_.reserve(near.order.size());
  for (std::size_t g = 0; g < near.count(); ++g) {
    const double* const centre = centres.data() + g * sites.dimension;
    double largest = 0;
    for (const SiteNumber s : near.of(g)) {
      rows_.push_back(sites.at(s));
      weight[g] = std::max(weight[g], sites.weight[s]);
      largest = std::max(largest, squared_difference(sites.at(s), centre, dimension_));
    }
    radius_[g] = std::sqrt(largest + underflow_of(dimension_)) * (1 + kSafe);
  }
}

double SiteGroups::distances_to(const double* place, std::vector<double>& out) const {
  out.resize(packs_.size() / static_cast<std::size_t>(dimension_));
  kernels::squared_distances(place, packs_.data(), static_cast<Index>(out.size()) / kernels::kPack,
                             dimension_, nullptr, out.data());
  out.resize(count());
  double farthest = 0;
  for (std::size_t g = 0; g < count(); ++g) {
    const double distance = std::sqrt(out[g]);
    farthest = std::max(farthest, (distance + radius_[g]) * (1 + kSafe));
    out[g] = std::max(0.0, distance * (1 - kSafe) - radius_[g]);
  }
  return farthest;
}

void SiteGroups::squared_to(const double* place, std::size_t group,
                            std::vector<double>& out) const {
  const std::size_t first = near.begin[group];
  out.resize(near.begin[group + 1] - first);
  kernels::squared_distances_of(rows_.data() + first, static_cast<Index>(out.size()), dimension_,
                                place, out.data());
}

}  // namespace ccvt
