#pragma once

#include <filesystem>

#include "ccvt/io.h"

namespace ccvt::io {

/// The vertices of a PLY file, ascii or binary of either byte order, as points: x and y, and z
/// where there is one, or the properties that `options` names, lists aside. Other properties and
/// elements are skipped. Messages count vertices from 0.
PointsHeader inspect_ply_points(const std::filesystem::path& path, const ReadOptions& options);
template <class Scalar>
void read_ply_points(const std::filesystem::path& path, const ReadOptions& options,
                     const detail::Allocation<Scalar>& allocation);

}  // namespace ccvt::io
