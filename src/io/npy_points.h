#pragma once

#include <filesystem>

#include "ccvt/io.h"

namespace ccvt::io {

/// Points of an .npy file of shape (#points, #dimensions), of any real type and either order.
PointsHeader inspect_npy_points(const std::filesystem::path& path, const ReadOptions& options);
template <class Scalar>
void read_npy_points(const std::filesystem::path& path, const ReadOptions& options,
                     const detail::Allocation<Scalar>& allocation);

}  // namespace ccvt::io
