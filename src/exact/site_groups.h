#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "exact/neighbourhoods.h"
#include "exact/weighted_sites.h"
#include "parallel/arena.h"

namespace ccvt {

/// Sites in groups of near ones, with what bounds all sites of a group together; in a space without
/// a torus.
struct SiteGroups {
  /// The positions must outlive the object. Of at most `most` sites each; see Neighbourhoods.
  SiteGroups(const WeightedSites& sites, std::size_t most, const Arena& arena);

  /// More than the rounding of distances and of their sums.
  static constexpr double kSafe = 1e-9;

  [[nodiscard]] std::size_t count() const { return near.count(); }
  [[nodiscard]] std::span<const SiteNumber> of(std::size_t group) const { return near.of(group); }
  /// The distances from a place to the nearest sites of all groups, at least; and the one to the
  /// farthest site, at most.
  double distances_to(const double* place, std::vector<double>& out) const;
  /// |place - s|^2 of the sites of a group.
  void squared_to(const double* place, std::size_t group, std::vector<double>& out) const;

  Neighbourhoods near;
  std::vector<double> centres;  ///< the means, one after the other
  std::vector<double> weight;   ///< of each group, the largest
 private:
  int dimension_;
  std::vector<double> packs_;        ///< the means, for the kernels
  std::vector<double> radius_;       ///< around the mean
  std::vector<const double*> rows_;  ///< positions in the groups' order
};

}  // namespace ccvt
