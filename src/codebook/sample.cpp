#include "codebook/sample.h"

#include <algorithm>
#include <cmath>

#include "random.h"

namespace ccvt {

void Sample::take_back(std::vector<double>& sites) const {
  for (std::size_t k = 0; k < sites.size(); ++k)
    sites[k] = sites[k] / scale + mean[k % mean.size()];
}

void Sample::bring_in(std::vector<double>& sites) const {
  for (std::size_t k = 0; k < sites.size(); ++k) {
    sites[k] = (sites[k] - mean[k % mean.size()]) * scale;
  }
}

template <class Scalar>
Sample sample_of(PointsView<Scalar> points, std::span<const Index> chosen) {
  const auto count = static_cast<Index>(chosen.size());
  Sample sample;
  std::vector<double>& mean = sample.mean;
  mean.assign(static_cast<std::size_t>(points.dimension), 0.0);
  for (const Index p : chosen) {
    for (std::size_t d = 0; d < mean.size(); ++d) {
      const double x = points[p][d];
      mean[d] += x / count;
    }
  }
  double largest = 0;
  for (const Index p : chosen) {
    for (std::size_t d = 0; d < mean.size(); ++d) {
      largest = std::max(largest, std::abs(points[p][d] - mean[d]));
    }
  }
  if (largest > 0) sample.scale = std::exp2(std::min(1000.0, -std::ceil(std::log2(largest))));
  sample.points.resize(points.dimension, count);
  float* to = sample.points.data();
  for (const Index p : chosen) {
    for (std::size_t d = 0; d < mean.size(); ++d) {
      *to++ = static_cast<float>((points[p][d] - mean[d]) * sample.scale);
    }
  }
  return sample;
}

std::vector<Index> draw_distinct(Index count, Index total, std::uint64_t seed,
                                 std::uint64_t stream) {
  std::vector<Index> chosen;
  chosen.reserve(static_cast<std::size_t>(count));
  Random(seed, stream).choose(std::min(count, total), total, [&](Index p) { chosen.push_back(p); });
  return chosen;
}

template Sample sample_of(PointsView<float>, std::span<const Index>);
template Sample sample_of(PointsView<double>, std::span<const Index>);

}  // namespace ccvt
