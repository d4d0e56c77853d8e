#pragma once

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "ccvt/ranks.h"
#include "ccvt/types.h"
#include "ccvt/volume.h"
#include "numbers.h"
#include "parallel/bytes.h"
#include "parallel/loops.h"

namespace ccvt {

/// How many points each site has, and the sum of the squares of their distances: in whole numbers
/// of a unit 2^63 times below the greatest square, whose sums are the same in any order.
class CellMeasures {
 public:
  /// No point is as far from its site as `beyond`.
  CellMeasures(std::size_t sites, double beyond)
      : scale_(std::exp2(-std::ilogb(beyond) - 1)), sums_(kSums * sites, 0) {}

  /// Points whose owners these are.
  template <class Scalar>
  void add(PointsView<Scalar> points, PointsView<Scalar> sites, const std::vector<Index>& owners,
           const Arena& arena) {
    constexpr std::size_t kPointsPerGrain = std::size_t{1} << 14;
    arena.for_each(owners.size(), kPointsPerGrain, [&](std::size_t k) {
      const PointNumber p(k);
      const SiteNumber s(owners[p]);
      double square = 0;
      for (int d = 0; d < points.dimension; ++d) {
        const double at = points[p.index()][d];
        const double difference = (at - sites[s.index()][d]) * scale_;
        square += difference * difference;
      }
      const double high = std::floor(square * kHigh);
      const double low = std::floor((square * kHigh - high) * kLow);
      const std::int64_t terms[kSums] = {1, static_cast<std::int64_t>(high),
                                         static_cast<std::int64_t>(low)};
      for (std::size_t v = 0; v < kSums; ++v) {
        std::atomic_ref(sums_[kSums * s + v]).fetch_add(terms[v], std::memory_order_relaxed);
      }
    });
  }

  /// Adds up what all ranks have, each some of the sites.
  void add_up(Ranks& ranks) {
    const auto count = static_cast<std::size_t>(ranks.count());
    const auto part = [&](std::size_t r) {
      const std::size_t begin = sums_.size() * r / count;
      return std::span(sums_).subspan(begin, sums_.size() * (r + 1) / count - begin);
    };
    std::vector<Ranks::Bytes> to;
    for (std::size_t r = 0; r < count; ++r) {
      const auto bytes = std::as_bytes(part(r));
      to.emplace_back(bytes.begin(), bytes.end());
    }
    const std::span<std::int64_t> own = part(static_cast<std::size_t>(ranks.rank()));
    std::fill(own.begin(), own.end(), 0);
    std::vector<std::int64_t> theirs(own.size());
    for (const Ranks::Bytes& bytes : ranks.exchange(std::move(to))) {
      ByteReader(bytes).get(std::span(theirs));
      for (std::size_t k = 0; k < own.size(); ++k) own[k] += theirs[k];
    }
    const std::vector<Ranks::Bytes> all = ranks.gather(std::as_bytes(own));
    for (std::size_t r = 0; r < count; ++r) ByteReader(all[r]).get(part(r));
  }

  /// Capacities and radii of the samples.
  void put(double dimension, VolumeSamples& samples) const {
    for (std::size_t s = 0; s < sums_.size() / kSums; ++s) {
      const std::int64_t* const sums = sums_.data() + kSums * s;
      const auto points = static_cast<double>(sums[0]);
      const double squares =
          static_cast<double>(sums[1]) / kHigh + static_cast<double>(sums[2]) / kHigh / kLow;
      samples.capacities.push_back(static_cast<Index>(sums[0]));
      samples.radii.push_back(std::sqrt((dimension + 2) / dimension * squares / points) / scale_);
    }
  }

 private:
  static constexpr std::size_t kSums = 3;  ///< of a site: points, and the parts of the squares
  static constexpr double kHigh = 0x1p31;
  static constexpr double kLow = 0x1p32;

  double scale_;
  std::vector<std::int64_t> sums_;
};

}  // namespace ccvt
