#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "ccvt/types.h"
#include "compensated_sum.h"
#include "geometry/metric.h"
#include "relax/site_state.h"
#include "relax/update.h"

namespace ccvt {

/// Cells that points leave and join: their sites, energies and radii follow without a look at the
/// points that stay.
class MovingCells {
 public:
  explicit MovingCells(const Metric& metric)
      : metric_(metric), dimension_(metric.coordinate_count()) {
    for (std::size_t d = 0; metric.periodic() && d < dimension_; ++d) {
      smallest_extent_ = std::min(smallest_extent_, metric.extent()[d]);
    }
  }

  /// Takes the cells as they are: so many points each, the sites at their centroids.
  void take(const SiteState& sites, const std::vector<Index>& sizes) {
    origin_ = sites.position;
    count_ = first_count_ = sizes;
    sums_.assign(sizes.size() * (dimension_ + 1), {});
    for (const SiteNumber s : sites.all()) square(s).add(sites.energy[s]);
  }

  template <class Scalar>
  void leave(SiteNumber site, const Scalar* x) {
    --count_[site];
    add(site, x, -1);
  }
  /// The radius grows so that it bounds the point's distance.
  template <class Scalar>
  void join(SiteState& sites, SiteNumber site, const Scalar* x) {
    ++count_[site];
    add(site, x, 1);
    const double squared = metric_.squared_distance(x, sites.at(site));
    sites.radius[site] = std::max(sites.radius[site], upper_radius(squared, metric_.dimension()));
  }

  [[nodiscard]] Index count(SiteNumber site) const { return count_[site]; }

  /// Whether the cell must be taken anew: it has changed so much that digits are lost, or is so
  /// large on a torus that not all images near to the site are the ones near to where it was taken.
  [[nodiscard]] bool worn(const SiteState& sites, SiteNumber site) const {
    const double moved =
        std::sqrt(metric_.squared_distance(&origin_[site * dimension_], sites.at(site)));
    return 2 * std::int64_t{count_[site]} < first_count_[site] ||
           count_[site] > 2 * std::int64_t{first_count_[site]} ||
           2.001 * (sites.radius[site] + moved) > smallest_extent_;
  }

  /// Moves a site that is not worn to its centroid, unless it is fixed. The radius grows by the
  /// move.
  void update(SiteState& sites, SiteNumber site) {
    if (sites.is_fixed(site)) {
      sites.energy[site] = std::max(0.0, square(site).value());
      return;
    }
    const double count = count_[site];
    double off = 0;
    double moved = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double mean = sums_[site * (dimension_ + 1) + d].value() / count;
      const double position = metric_.into_box(origin_[site * dimension_ + d] + mean, d);
      off += mean * mean;
      moved += std::pow(metric_.wrap(position - sites.at(site)[d], d), 2);
      sites.at(site)[d] = position;
    }
    sites.energy[site] = std::max(0.0, square(site).value() - count * off);
    sites.radius[site] =
        upper_radius(std::pow(sites.radius[site] + std::sqrt(moved), 2), metric_.dimension());
  }

 private:
  CompensatedSum& square(SiteNumber site) { return sums_[site * (dimension_ + 1) + dimension_]; }
  template <class Scalar>
  void add(SiteNumber site, const Scalar* x, double sign) {
    CompensatedSum* const sums = &sums_[site * (dimension_ + 1)];
    double squared = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double to = x[d];
      const double u = metric_.wrap(to - origin_[site * dimension_ + d], d);
      sums[d].add(sign * u);
      squared += u * u;
    }
    sums[dimension_].add(sign * squared);
  }

  const Metric& metric_;
  std::size_t dimension_;
  double smallest_extent_ = std::numeric_limits<double>::infinity();
  std::vector<double> origin_;  ///< of the sites, where they were taken
  std::vector<Index> count_;
  std::vector<Index> first_count_;
  std::vector<CompensatedSum> sums_;  ///< of each site, for each dimension and of the squares
};

}  // namespace ccvt
