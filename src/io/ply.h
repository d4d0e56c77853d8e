#pragma once

#include <cstdint>
#include <filesystem>

#include "ccvt/io.h"
#include "io/ply_file.h"

namespace ccvt::io {

/// The vertices of a PLY file, ascii or binary of either byte order, as points: x and y, and z
/// where there is one, or the properties that `options` names, lists aside. Other properties and
/// elements are skipped. Messages count vertices from 0.
PointsHeader inspect_ply_points(const std::filesystem::path& path, const ReadOptions& options);
template <class Scalar>
void read_ply_points(const std::filesystem::path& path, const ReadOptions& options,
                     const detail::Allocation<Scalar>& allocation);

/// The vertices, with the properties that are coordinates under their axes as slots.
PlyElement& find_ply_vertices(PlyFile& ply, const ReadOptions& options);
/// How they store their coordinates.
PointsHeader ply_header(const PlyElement& vertices);
/// Throws for a coordinate that is no number of its type.
[[noreturn]] void fail_ply_coordinate(PlyFile& ply, const PlyElement& vertices, std::int64_t vertex,
                                      int axis, double value);

}  // namespace ccvt::io
