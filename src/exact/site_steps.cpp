#include "exact/site_steps.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "exact/distances.h"
#include "kernels/products.h"

namespace ccvt {
namespace {

/// Steps that sites are multiplied with at a time, or as many as products are of.
constexpr std::size_t kLeastSteps = 64;
constexpr std::size_t kStepsPerGrain = 128;

}  // namespace

SiteSteps::SiteSteps(std::span<const double> from, std::span<const double> to,
                     std::size_t dimension, const Arena& arena)
    : dimension_(dimension),
      steps_(std::max(kLeastSteps, static_cast<std::size_t>(kernels::product_points()))),
      moves_(from.size() / dimension, 0),
      centre_(dimension, 0.0) {
  const std::size_t n = moves_.size();
  std::size_t moved = 0;
  for (std::size_t s = 0; s < n; ++s) {
    const auto x = from.subspan(s * dimension, dimension);
    const auto y = to.subspan(s * dimension, dimension);
    if (!std::equal(x.begin(), x.end(), y.begin())) moves_[s] = 1;
    moved += moves_[s];
    for (std::size_t d = 0; d < dimension; ++d) centre_[d] += x[d] / static_cast<double>(n);
  }
  if (moved == 0) return;
  all_ = 2 * moved >= n;
  for (const SiteNumber s : sites_below(n)) {
    if (all_ || moves_[s] != 0) moved_.push_back(s);
  }
  double largest = 0;
  double longest = 0;
  for (std::size_t s = 0; s < n; ++s) {
    const auto x = from.subspan(s * dimension, dimension);
    const auto y = to.subspan(s * dimension, dimension);
    for (std::size_t d = 0; d < dimension; ++d) {
      largest = std::max(largest, std::abs(y[d] - centre_[d]));
      longest = std::max(longest, std::abs(y[d] - x[d]));
    }
  }
  scale_ = scale_for(largest);
  const double scale = scale_for(longest);
  unscale_ = 1 / (scale_ * scale);
  const auto terms = static_cast<double>(dimension);
  // What underflow does to a product.
  const double beside = 4 * terms * double{std::numeric_limits<float>::min()} * unscale_;
  const double share = rounding_share(static_cast<int>(dimension));
  const double underflow = underflow_of(static_cast<int>(dimension));
  const std::size_t padded = (moved_.size() + steps_ - 1) / steps_ * steps_;
  block_.assign(padded * dimension, 0.0F);
  length_.resize(moved_.size());
  shift_.resize(moved_.size());
  arena.for_each(moved_.size(), kStepsPerGrain, [&](std::size_t k) {
    const double* const x = from.data() + moved_[k] * dimension;
    const double* const y = to.data() + moved_[k] * dimension;
    float* const stream = block_.data() + k / steps_ * steps_ * dimension + k % steps_;
    double squared = 0;
    double shift = 0;
    double sizes = 0;
    for (std::size_t d = 0; d < dimension; ++d) {
      const double step = y[d] - x[d];
      const double a = x[d] - centre_[d];
      const double b = y[d] - centre_[d];
      squared += step * step;
      shift += step * (a + b);
      sizes += std::abs(step) * (std::abs(a) + std::abs(b));
      stream[d * steps_] = static_cast<float>(step * scale);
    }
    const bool moves = moves_[moved_[k]] != 0;
    length_[k] = moves ? std::sqrt(squared + underflow) * (1 + share) : 0;
    shift_[k] = moves ? shift - share * sizes - underflow - beside : 0;
  });
}

void SiteSteps::follow(std::span<const Cell> cells, Scratch& scratch) const {
  const auto dimension = static_cast<int>(dimension_);
  const std::size_t tile = kernels::kCostSites;
  const std::size_t padded = (cells.size() + tile - 1) / tile * tile;
  scratch.site.assign(padded * dimension_, 0.0F);
  scratch.dot.resize(padded * steps_);
  scratch.lowest.assign(steps_ + padded, 0.0F);
  const float* const none = scratch.lowest.data() + steps_;
  // Of the rounding of a site, of a step, and of a sum of so many products.
  const double margin = (dimension + 6) * double{std::numeric_limits<float>::epsilon()};
  scratch.reach.clear();
  for (std::size_t k = 0; k < cells.size(); ++k) {
    double squared = 0;
    for (std::size_t d = 0; d < dimension_; ++d) {
      const double x = cells[k].site[d] - centre_[d];
      squared += x * x;
      scratch.site[k * dimension_ + d] = static_cast<float>(2 * scale_ * x);
    }
    scratch.reach.push_back(2 * (cells[k].radius + margin * std::sqrt(squared)));
  }
  for (std::size_t first = 0; first < moved_.size(); first += steps_) {
    const std::size_t count = std::min(steps_, moved_.size() - first);
    kernels::site_costs(block_.data() + first * dimension_, static_cast<Index>(steps_), dimension,
                        scratch.site.data(), none, static_cast<Index>(padded), scratch.dot.data(),
                        scratch.lowest.data());
    for (std::size_t k = 0; k < cells.size(); ++k) {
      const float* const dot = scratch.dot.data() + k * steps_;
      const kernels::BoundChange change{unscale_, scratch.reach[k], all_ ? cells[k].growth : 0};
      double* const bound = cells[k].bound;
      if (all_) {
        change_some(dot, first, count, change, bound + first);
        continue;
      }
      const auto moved = std::span(moved_).subspan(first, count);
      scratch.bound.clear();
      for (const SiteNumber j : moved) scratch.bound.push_back(bound[j]);
      change_some(dot, first, count, change, scratch.bound.data());
      for (std::size_t step = 0; step < count; ++step) bound[moved[step]] = scratch.bound[step];
    }
  }
}

/// Of steps from the `first`.
void SiteSteps::change_some(const float* dot, std::size_t first, std::size_t count,
                            const kernels::BoundChange& change, double* bound) const {
  kernels::change_bounds(dot, shift_.data() + first, length_.data() + first,
                         static_cast<Index>(count), change, bound);
}

}  // namespace ccvt
