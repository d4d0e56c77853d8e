#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "ccvt/point_cloud.h"
#include "io/formats.h"
#include "io/ply_file.h"

namespace ccvt {

/// Of a PLY file the vertices, each as it is encoded, in ascii its words with a blank after each;
/// of a text file the fields of each line, with their quotes, and a line feed after each. Of other
/// files nothing.
struct PointCloud::Records {
  enum class Kind { none, ply, text };

  Kind kind = Kind::none;
  io::PlyFile::Encoding encoding = io::PlyFile::Encoding::ascii;
  std::vector<std::string> comments;
  std::vector<io::PlyProperty> properties;
  std::vector<std::string> names;  ///< of the columns of a text file; empty where there are none
  std::string bytes;
  std::vector<std::size_t> first;  ///< of each record, and the end

  [[nodiscard]] std::string_view record(Index point) const {
    const auto p = static_cast<std::size_t>(point);
    return std::string_view(bytes).substr(first[p], first[p + 1] - first[p]);
  }
};

namespace io {

/// The name of a new column or property `count`, among others of these names.
std::string count_name(const std::vector<std::string>& names);

/// Where nx, ny and nz are among the names, in capitals or not; nothing unless there is one of each
/// and is_free(place) holds for all.
template <class IsFree>
std::vector<std::size_t> find_normals(const std::vector<std::string>& names,
                                      const IsFree& is_free) {
  std::vector<std::size_t> at;
  for (const std::string_view wanted : {"nx", "ny", "nz"}) {
    const auto named = [&](const std::string& name) { return in_lower_case(name) == wanted; };
    const auto found = std::find_if(names.begin(), names.end(), named);
    if (found == names.end() || std::find_if(found + 1, names.end(), named) != names.end()) {
      return {};
    }
    at.push_back(static_cast<std::size_t>(found - names.begin()));
    if (!is_free(at.back())) return {};
  }
  return at;
}

/// The file, with its records.
PointCloud read_ply_cloud(const std::filesystem::path& path, const ReadOptions& options);
PointCloud read_text_cloud(const std::filesystem::path& path, const ReadOptions& options);

}  // namespace io
}  // namespace ccvt
