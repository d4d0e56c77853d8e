#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "ccvt/types.h"

/// Other ways to choose points from a cloud in space.
namespace ccvt::bench {

using Chosen = std::vector<Index>;

/// Each set of `count` equally likely.
Chosen random_choice(const Eigen::Matrix3Xf& points, Index count, std::uint64_t seed);

/// In each voxel the point nearest to the centroid of its points. Voxels are as large as gives the
/// number nearest to `count`.
Chosen voxel_choice(const Eigen::Matrix3Xf& points, Index count);

/// Each next point is the one farthest from all before, from point 0 on. O(count * points).
Chosen farthest(const Eigen::Matrix3Xf& points, Index count);

/// Weighted sample elimination [C. Yuksel, Sample Elimination for Generating Poisson Disk Sample
/// Sets, Computer Graphics Forum 34 (2), 2015], with weight limiting and the parameters of the
/// paper (alpha 8, beta .65, gamma 1.5), on a surface of this area.
Chosen sample_elimination(const Eigen::Matrix3Xf& points, Index count, double area);

}  // namespace ccvt::bench
