#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "ccvt/types.h"

namespace ccvt {

/// Some of the points, in float relative to their mean, in units in which squares do not overflow.
struct Sample {
  Points<float> points;
  std::vector<double> mean;
  double scale = 1;

  /// Sites of the sample, one after the other, among the points that it was taken from.
  void take_back(std::vector<double>& sites) const;
  /// The other way round.
  void bring_in(std::vector<double>& sites) const;
};

template <class Scalar>
Sample sample_of(PointsView<Scalar> points, std::span<const Index> chosen);

/// `count` distinct numbers below `total`, ascending.
std::vector<Index> draw_distinct(Index count, Index total, std::uint64_t seed,
                                 std::uint64_t stream);

}  // namespace ccvt
