#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>

#include "ccvt/io.h"
#include "ccvt/types.h"
#include "io/input_file.h"
#include "io/point_layout.h"
#include "io/points_map.h"

/// Files of vectors as search benchmarks have them: of each vector its dimension, an int32, and
/// then as many float32 (.fvecs) or uint8 (.bvecs); little endian.
namespace ccvt::io {

[[nodiscard]] bool is_vecs(const std::filesystem::path& path);

/// Both throw InvalidInput unless the file holds at least one vector, all of one dimension, and
/// nothing else; read_vecs() does not look whether coordinates are finite. Of the vectors, those
/// that `options` ask for are counted, read and looked at.
PointsHeader inspect_vecs(const std::filesystem::path& path, const ReadOptions& options);
template <class Scalar>
PointsMap<Scalar> read_vecs(const std::filesystem::path& path, const ReadOptions& options,
                            const detail::Allocation<Scalar>& allocation);

/// Of .fvecs; nothing for .bvecs. Looks at the first vector and the size only.
std::optional<PointLayout> layout_of_vecs(const std::filesystem::path& path);
/// Of all bytes of a file: throws InvalidInput unless the vectors of `rows` have the dimension of
/// the first of all.
void check_dimensions(const InputFile& file, const std::byte* bytes, const PointLayout& layout,
                      const RowRange& rows);

}  // namespace ccvt::io
