#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "exact/site_groups.h"
#include "numbers.h"

namespace ccvt {

/// Points around a centre that have owners, and the sites that may cost some of them less.
///
/// With r the distance of a point to the centre, and u what its owner costs it, a site at distance
/// L from the centre costs it (L - r)^2 less the site's weight at least (triangle inequality). The
/// least over the points of r^2 - 2 L r - u is a concave function of L: between two distances at
/// which it is known it is no less than on the line between them.
class Rivals {
 public:
  struct Site {
    SiteNumber site;
    double squared;  ///< distance to the centre
  };

  void clear() {
    squared_.clear();
    reduced_.clear();
    radius_ = terms_ = 0;
  }
  /// A point at this squared distance from the centre, whose owner costs it so much, less its
  /// weight.
  void add(double squared, double cost, double weight) {
    squared_.push_back(squared);
    reduced_.push_back(cost - weight);
    radius_ = std::max(radius_, std::sqrt(squared));
    terms_ = std::max(terms_, cost + std::abs(weight));
  }
  /// Of the points added. `weights`: of all sites. O(points), and O(D) for each group and each site
  /// of the groups that come near.
  const std::vector<Site>& find(const SiteGroups& groups, std::span<const double> weights,
                                const double* centre, int dimension);

 private:
  void tabulate();
  [[nodiscard]] double excess(double distance) const;

  std::vector<double> squared_;
  std::vector<double> reduced_;
  double radius_ = 0;             ///< the largest distance to the centre
  double terms_ = 0;              ///< the largest of what costs are sums of
  double farthest_ = 0;           ///< no site is farther from the centre
  std::vector<double> least_;     ///< the concave function, at distances up to that
  std::vector<double> distance_;  ///< of each group
  std::vector<double> apart_;
  std::vector<Site> found_;
};

}  // namespace ccvt
