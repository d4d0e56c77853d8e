#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "ccvt/surface.h"
#include "io/input_file.h"

namespace ccvt::io {

/// A mesh as its file is read.
struct MeshParts {
  std::vector<double> coordinates;  ///< three for each vertex
  std::vector<double> density;      ///< one for each vertex, or none at all
  std::vector<Index> corners;       ///< three for each triangle

  /// The triangles of a face, around its first corner: three corners or more. Throws when they
  /// become too many to be numbered.
  void add_face(const InputFile& file, std::span<const Index> face);
  /// When all vertices are known: other triangles for faces that such fans do not fit.
  void divide_concave_faces();

 private:
  struct Fan {
    std::size_t first;  ///< of `corners`
    std::size_t triangles;
  };
  std::vector<Fan> fans_;  ///< of several triangles
};

/// `density`: the colour that is the density; empty: none.
MeshParts read_obj(const std::filesystem::path& path, const std::string& density);

}  // namespace ccvt::io
