#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ccvt/columns.h"
#include "ccvt/export.h"
#include "ccvt/io.h"
#include "ccvt/types.h"

namespace ccvt {

/// The points of a file, and all that it says of each, to be written again.
struct PointCloud {
  /// What holds the coordinates exactly.
  ScalarType scalar = ScalarType::float64;
  /// #dimensions by #points.
  Columns<double> points;
  /// 3 by #points, as they are in the file, of any length: of points in space whose file has nx, ny
  /// and nz; else empty. Those that are not finite are 0: nothing is known of them.
  Columns<double> normals;
  Index unknown_normals = 0;
  /// What beside coordinates and normals is kept of each point, by its name in the file.
  std::vector<std::string> kept;
  /// Elements of a PLY file other than its vertices. They are not kept.
  std::vector<std::string> dropped;

  /// The points as they are in their file.
  struct Records;
  std::shared_ptr<const Records> records;
};

/// Reads any file of points (see io.h), with all properties of the vertices of a PLY file, and all
/// fields of the lines of a text file. Throws as read_points() does.
CCVT_EXPORT PointCloud read_point_cloud(const std::filesystem::path& path,
                                        const ReadOptions& options = {});

/// Writes the points whose numbers are `chosen`, in that order, and how many points each stands
/// for, which `counts` says:
///
///   .ply        From PLY: the encoding, comments and properties of the file, lists too, bit by
///               bit, or word by word where it is ascii, and after them the property `int count`.
///               It is count_2 where the file has a count already, and so on. From other files: x,
///               y and z, as many as there are, and the count; at most 3 dimensions.
///   .csv, .txt  From text: all fields, word by word, and the count; a header where the file has
///               one. From other files: the coordinates and the count.
///   .npy        The coordinates.
///
/// Throws InvalidInput for another extension, a number that is no point's, and unless there is one
/// count for each; IoError when the system refuses. See io.h for how files are replaced.
CCVT_EXPORT void write_point_cloud(const std::filesystem::path& path, const PointCloud& cloud,
                                   std::span<const Index> chosen, std::span<const Index> counts);

}  // namespace ccvt
