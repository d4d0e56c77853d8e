#include "relax/apart.h"

#include <algorithm>
#include <cmath>

namespace ccvt {
namespace {

/// Of the points of a block, how far the farthest is from a site.
template <class Scalar>
double farthest(const Scalar* block, Index stride, Index count, const double* site, int dimension) {
  double farthest = 0;
  for (Index k = 0; k < count; ++k) {
    double squared = 0;
    const Scalar* x = block + k;
    for (int d = 0; d < dimension; ++d, x += stride) squared += (*x - site[d]) * (*x - site[d]);
    farthest = std::max(farthest, squared);
  }
  return std::sqrt(farthest);
}

}  // namespace

/// Both cells must lie in one frame, as the cut does.
template <class Scalar>
bool Apart<Scalar>::possible(const Pair& pair) {
  return pair.cut.straight() && !pair.cut.crosses_faces() &&
         pair.patches.has(pair.i) != pair.patches.has(pair.j) &&
         pair.metric.dimension() <= static_cast<int>(kMostDimensions);
}

/// By the cut as it was, the key of the point of a block that is the nearest to the other cell.
template <class Scalar>
double Apart<Scalar>::key(const Pair& pair, SiteNumber cell, const Scalar* block, Index stride,
                          Index count) const {
  const auto beyond = cell == pair.i ? kernels::Beyond::above : kernels::Beyond::below;
  const kernels::Cut<Scalar> cut{middle_.data(), normal_.data()};
  const double key =
      kernels::extreme_key(block, stride, count, pair.metric.dimension(), cut, beyond);
  return pair.large_is_i() ? key : -key;
}

template <class Scalar>
void Apart<Scalar>::note(const Pair& pair, const Scalar* near, Index stride, Index count,
                         double others) {
  known_ = possible(pair);
  if (!known_) return;
  const auto& [metric, cut, cells, patches, sites, i, j] = pair;
  const SiteNumber large = pair.large();
  const SiteNumber small = pair.small();
  const auto dimension = static_cast<std::size_t>(metric.dimension());
  const kernels::Cut<Scalar> now = cut.straight_cut(pair.large_is_i() ? Side::i : Side::j);
  std::copy_n(now.middle, dimension, middle_.begin());
  std::copy_n(now.normal, dimension, normal_.begin());
  std::copy_n(sites.at(i), dimension, sites_.begin());
  std::copy_n(sites.at(j), dimension, sites_.begin() + kMostDimensions);
  exchanged_ = patches.exchanged(small);
  version_ = patches.changes(large).version;
  changes_ = static_cast<std::uint32_t>(patches.changes(large).places.size());
  tolerance_ = cut.tolerance();
  const Index size = cells.size(small);
  own_ = {key(pair, small, cells.block(small), size, size) - tolerance_, sites.radius[small]};
  far_ = {(pair.large_is_i() ? others : -others) + tolerance_, cut.length() + sites.radius[large]};
  near_ = far_;
  if (count == 0) return;
  near_ = {key(pair, large, near, stride, count) + tolerance_,
           farthest(near, stride, count, sites.at(small), metric.dimension())};
}

/// How far the sites are from where they were, both together.
template <class Scalar>
double Apart<Scalar>::moved(const Pair& pair) const {
  const double* const before = sites_.data();
  return std::sqrt(pair.metric.squared_distance(pair.sites.at(pair.i), before)) +
         std::sqrt(pair.metric.squared_distance(pair.sites.at(pair.j), before + kMostDimensions));
}

/// Looks at points that have come: at all of the small cell.
template <class Scalar>
void Apart<Scalar>::look_at_changes(const Pair& pair, double moved) {
  const auto& [metric, cut, cells, patches, sites, i, j] = pair;
  const SiteNumber small = pair.small();
  const SiteNumber large = pair.large();
  // Of points that are farther away than any were.
  tolerance_ = std::max(tolerance_, cut.tolerance());
  if (exchanged_ != patches.exchanged(small)) {
    exchanged_ = patches.exchanged(small);
    const Index size = cells.size(small);
    own_ = {key(pair, small, cells.block(small), size, size) - tolerance_,
            sites.radius[small] + moved};
  }
  const typename Patches<Scalar>::Changes& changes = patches.changes(large);
  const std::size_t known = changes_;
  if (known == changes.places.size()) return;
  changes_ = static_cast<std::uint32_t>(changes.places.size());
  const double come = key(pair, large, changes.come.data() + known,
                          static_cast<Index>(changes.room), static_cast<Index>(changes_ - known));
  far_ = {std::max(far_.key, come + tolerance_),
          std::max(far_.reach, cut.length() + sites.radius[large] + moved)};
}

template <class Scalar>
bool Apart<Scalar>::holds(const Pair& pair) {
  known_ = known_ && possible(pair) && version_ == pair.patches.changes(pair.large()).version;
  if (!known_) return false;
  const double by = moved(pair);
  // Then the cut was at most twice as long, and keys by it had errors of at most four tolerances.
  known_ = by <= pair.cut.length();
  if (!known_) return false;
  look_at_changes(pair, by);
  const double rounding = 6 * tolerance_;
  const auto apart_from = [&](const Part& part) {
    return own_.key - part.key > (own_.reach + part.reach) * by + rounding;
  };
  return known_ = apart_from(near_) && apart_from(far_);
}

template class Apart<float>;
template class Apart<double>;

}  // namespace ccvt
