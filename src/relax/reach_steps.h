#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "kernels/products.h"
#include "parallel/arena.h"
#include "relax/screen_cells.h"
#include "relax/site_state.h"

namespace ccvt {

/// Of all sites: where they are, relative to their mean, and by which step they came there.
template <class Scalar>
struct ReachSteps {
  /// Rows of a product.
  static constexpr std::size_t kRows = kernels::kCostSites;

  ReachSteps(const SiteState& sites, const CentredSites<Scalar>& centred,
             const std::vector<double>& before, const Arena& arena)
      : count(sites.count()), dimension(sites.dimension) {
    const auto points = static_cast<std::size_t>(kernels::product_points());
    stride = (count + points - 1) / points * points;
    step.resize(count * dimension);
    row.resize((count + kRows) * dimension);
    step_streams.resize(stride * dimension);
    site_streams.resize(stride * dimension);
    for (auto* values : {&norm, &squared_norm, &radius, &length, &constant}) values->resize(count);
    arena.for_ranges(count, 16, [&](std::size_t begin, std::size_t end, int) {
      for (const SiteNumber s : sites_between(begin, end)) {
        double squared = 0;
        double along = 0;
        for (std::size_t d = 0; d < dimension; ++d) {
          const double to = centred.at(s, d);
          const double by = sites.at(s)[d] - before[s * dimension + d];
          step[s * dimension + d] = by;
          row[s * dimension + d] = static_cast<float>(to);
          step_streams[d * stride + s] = static_cast<float>(by);
          site_streams[d * stride + s] = static_cast<float>(to);
          squared += by * by;
          along += to * by;
        }
        norm[s] = static_cast<Scalar>(centred.norms()[s]);
        squared_norm[s] = norm[s] * norm[s];
        radius[s] = static_cast<Scalar>(sites.radius[s]);
        length[s] = static_cast<Scalar>(std::sqrt(squared));
        constant[s] = static_cast<Scalar>(squared - 2 * along);
      }
    });
    const double terms = 4 * (static_cast<double>(dimension) + 4);
    share = static_cast<Scalar>(terms * std::numeric_limits<float>::epsilon());
    // The reach found anew is rounded up by less, and must not be more than what is kept.
    pair_share = static_cast<Scalar>(4 * centred.rounding_share());
    underflow = 4 * centred.underflow() + terms * std::numeric_limits<float>::denorm_min();
  }

  std::size_t count;
  std::size_t dimension;
  std::size_t stride;        ///< of the streams, one for each dimension
  std::vector<double> step;  ///< of one site after the other
  std::vector<float> row;    ///< positions, likewise
  std::vector<float> step_streams;
  std::vector<float> site_streams;
  std::vector<Scalar> norm;
  std::vector<Scalar> squared_norm;
  std::vector<Scalar> radius;
  std::vector<Scalar> length;    ///< of the step
  std::vector<Scalar> constant;  ///< |step|^2 - 2 site . step
  // What rounding can add, at most: of |a| |b| to a product of floats and to sums of its size; of
  // what CentredSites::rounding() has; and apart.
  Scalar share;
  Scalar pair_share;
  double underflow;
};

}  // namespace ccvt
