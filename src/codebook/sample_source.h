#pragma once

#include <cstdint>
#include <vector>

#include "ccvt/types.h"
#include "codebook/sample.h"
#include "codebook/vectors.h"
#include "parallel/arena.h"

namespace ccvt {

/// The points that samples for a search are taken from, and their regions.
template <class Scalar>
class SampleSource {
 public:
  /// `first`: points a site of the smallest sample to come.
  SampleSource(const Vectors<Scalar>& vectors, Index sites, std::int64_t first, std::uint64_t seed,
               const Arena& arena);

  /// So many points a site, the same share of each region.
  [[nodiscard]] Sample sample(std::int64_t per_site) const;
  [[nodiscard]] Index size(std::int64_t per_site) const;

 private:
  Index count_;  ///< of all ranks
  Index sites_;
  const Arena& arena_;
  std::uint64_t seed_;
  Points<Scalar> gathered_;    ///< of several ranks, what samples are taken from
  PointsView<Scalar> points_;  ///< that, or all
  std::vector<Index> chosen_;  ///< among `points_`
  Sample all_;
  std::vector<double> middles_;
};

extern template class SampleSource<float>;
extern template class SampleSource<double>;

}  // namespace ccvt
