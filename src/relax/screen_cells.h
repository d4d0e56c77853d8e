#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "geometry/metric.h"
#include "kernels/products.h"
#include "relax/cells.h"
#include "relax/site_state.h"

namespace ccvt {

/// All sites relative to their mean, and how far from it they are.
template <class Scalar>
class CentredSites {
 public:
  explicit CentredSites(const SiteState& sites) : sites_(sites), norm_(sites.count()) {
    mean_.assign(sites.dimension, 0.0);
    for (const SiteNumber s : sites.all()) {
      for (std::size_t d = 0; d < sites.dimension; ++d) mean_[d] += sites.at(s)[d];
    }
    const auto count = static_cast<double>(sites.count());
    for (double& m : mean_) m /= count;
    for (const SiteNumber s : sites.all()) {
      double sum = 0;
      for (std::size_t d = 0; d < sites.dimension; ++d) {
        sum += std::pow(sites.at(s)[d] - mean_[d], 2);
      }
      norm_[s] = std::sqrt(sum);
    }
  }

  [[nodiscard]] Scalar at(SiteNumber site, std::size_t d) const {
    return static_cast<Scalar>(sites_.at(site)[d] - mean_[d]);
  }
  [[nodiscard]] const std::vector<double>& norms() const { return norm_; }
  /// How much rounding can add to what is found of a pair, at most.
  [[nodiscard]] double rounding(SiteNumber i, SiteNumber j) const {
    return rounding_share() * (sites_.radius[i] + sites_.radius[j]) * (norm_[i] + norm_[j]) +
           underflow();
  }
  [[nodiscard]] double rounding_share() const {
    return 4 * (static_cast<double>(sites_.dimension) + 4) * std::numeric_limits<Scalar>::epsilon();
  }
  [[nodiscard]] double underflow() const {
    return 4 * (static_cast<double>(sites_.dimension) + 4) *
           std::numeric_limits<Scalar>::denorm_min();
  }

 private:
  const SiteState& sites_;
  std::vector<double> mean_;
  std::vector<double> norm_;
};

/// A cell relative to its site, padded for the kernel.
template <class Scalar>
struct CentredCell {
  void load(const Cells<Scalar>& cells, const SiteState& sites, const CentredSites<Scalar>& centred,
            SiteNumber site) {
    const Index count = cells.size(site);
    const Index step = kernels::dot_points<Scalar>();
    stride = (count + step - 1) / step * step;
    const auto padded = static_cast<std::size_t>(stride);
    block.resize(padded * sites.dimension);
    offset.assign(padded, Scalar{0});
    const Scalar* from = cells.block(site);
    Scalar* to = block.data();
    for (std::size_t d = 0; d < sites.dimension; ++d, from += count, to += stride) {
      const double origin = sites.at(site)[d];
      const Scalar own = centred.at(site, d);
      for (Index k = 0; k < count; ++k) {
        to[k] = static_cast<Scalar>(from[k] - origin);
      }
      std::fill(to + count, to + stride, to[count - 1]);
      for (std::size_t k = 0; k < padded; ++k) offset[k] += to[k] * own;
    }
  }

  std::vector<Scalar> block;
  std::vector<Scalar> offset;  ///< point . own site
  Index stride = 0;
};

/// The reach of cell i for site j: the largest of |p - s_i|^2 - |p - s_j|^2 over its points, and no
/// less than that for rounding. `largest`: of (p - s_i) . (s_j - s_i).
template <class Scalar>
Scalar reach_of(double largest, double squared_distance, double rounding) {
  const double reach = 2 * largest - squared_distance + rounding;
  return static_cast<Scalar>(reach + std::numeric_limits<Scalar>::epsilon() * std::abs(reach));
}

}  // namespace ccvt
