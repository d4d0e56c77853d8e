#include "codebook/sample_source.h"

#include <algorithm>
#include <numeric>
#include <span>

#include "codebook/plus_plus.h"
#include "codebook/share.h"
#include "streams.h"

namespace ccvt {
namespace {

/// Points a site of those that samples are taken from.
constexpr std::int64_t kSource = 1024;
/// Samples have no fewer points than this.
constexpr std::int64_t kLeastSample = 1024;
/// Regions a site that have their share of the samples: the smaller they are, the less does what is
/// best on a sample differ from what is best; in many dimensions they cost more than they save.
constexpr int kMostRegions = 16;
constexpr int kLeastRegions = 4;
constexpr int kRegionDimensions = 512;

std::int64_t regions_per_site(int dimension) {
  return std::clamp(kRegionDimensions / dimension, kLeastRegions, kMostRegions);
}

}  // namespace

template <class Scalar>
SampleSource<Scalar>::SampleSource(const Vectors<Scalar>& vectors, Index sites, std::int64_t first,
                                   std::uint64_t seed, const Arena& arena)
    : count_(vectors.count()),
      sites_(sites),
      arena_(arena),
      seed_(seed),
      points_(vectors.here()),
      chosen_(draw_distinct(size(kSource), count_, seed, streams::codebook_sample)) {
  if (vectors.part().ranks != nullptr) {
    gathered_ = vectors.chosen(chosen_);
    points_ = view_points(gathered_);
    std::iota(chosen_.begin(), chosen_.end(), 0);
  }
  all_ = sample_of(points_, std::span<const Index>(chosen_));
  const std::int64_t regions =
      std::min<std::int64_t>(size(first), regions_per_site(points_.dimension) * sites);
  middles_ = plus_plus_in_rounds(view_points(all_.points), static_cast<Index>(regions), seed,
                                 streams::codebook_breeding, arena);
}

template <class Scalar>
Sample SampleSource<Scalar>::sample(std::int64_t per_site) const {
  std::vector<Index> numbers =
      draw_evenly<float>(view_points(all_.points), middles_, size(per_site), seed_, arena_);
  for (Index& number : numbers) number = chosen_[static_cast<std::size_t>(number)];
  return sample_of(points_, std::span<const Index>(numbers));
}

template <class Scalar>
Index SampleSource<Scalar>::size(std::int64_t per_site) const {
  return static_cast<Index>(
      std::min<std::int64_t>(count_, std::max(kLeastSample, per_site * sites_)));
}

template class SampleSource<float>;
template class SampleSource<double>;

}  // namespace ccvt
