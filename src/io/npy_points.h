#pragma once

#include <filesystem>
#include <optional>

#include "ccvt/io.h"
#include "io/point_layout.h"

namespace ccvt::io {

/// Points of an .npy file of shape (#points, #dimensions), of any real type and either order.
PointsHeader inspect_npy_points(const std::filesystem::path& path, const ReadOptions& options);
template <class Scalar>
void read_npy_points(const std::filesystem::path& path, const ReadOptions& options,
                     const detail::Allocation<Scalar>& allocation);

/// Nothing unless they are float32 or float64 as this machine has them, in C order.
std::optional<PointLayout> layout_of_npy(const std::filesystem::path& path);

}  // namespace ccvt::io
