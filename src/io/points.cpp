#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "checks.h"
#include "geometry/as_matrix.h"
#include "geometry/finite_points.h"
#include "io/columns.h"
#include "io/finite.h"
#include "io/formats.h"
#include "io/gadget.h"
#include "io/hdf5_particles.h"
#include "io/input_file.h"
#include "io/npy.h"
#include "io/npy_numbers.h"
#include "io/npy_points.h"
#include "io/output_file.h"
#include "io/ply.h"
#include "io/points_map.h"
#include "io/text.h"
#include "io/vecs.h"
#include "io/whole.h"
#include "number_text.h"

namespace ccvt {

namespace {

using io::InputFile;
using io::PointsMap;
using io::TextRows;

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr Eigen::Index kMostPoints = std::numeric_limits<Index>::max();
constexpr std::uint64_t kMostDimensions = std::uint64_t{1} << 24;

[[noreturn]] void fail_extension(const std::filesystem::path& path, const char* what,
                                 io::Extensions allowed) {
  throw InvalidInput(path.string() + ": unknown extension " + io::quoted(io::extension_of(path)) +
                     "; " + what + " " + io::list_of(allowed, " or "));
}

/// Of a file of points or whole numbers that is written, or of whole numbers that is read, as
/// `what` tells.
std::string table_extension(const std::filesystem::path& path,
                            const char* what = "points and owners go into") {
  std::string extension = io::extension_of(path);
  if (io::is_among(io::kTableFiles, extension)) return extension;
  fail_extension(path, what, io::kTableFiles);
}

void refuse_part(const std::filesystem::path& path, const ReadOptions& options,
                 const std::string& extension) {
  if (extension == ".npy" || io::is_vecs(path)) return;
  if (options.first_row == 0 && options.end_row == UINT64_MAX) return;
  throw InvalidInput(path.string() +
                     ": first_row and end_row ask for a part of the rows, which is read of .npy, "
                     ".fvecs and .bvecs files only");
}

/// Of a file of points that is read.
std::string points_extension(const std::filesystem::path& path) {
  std::string extension = io::extension_of(path);
  if (io::is_among(io::kPointFiles, extension)) return extension;
  fail_extension(path, "points come from", io::kPointFiles);
}

/// Which columns of the row that `rows` is at are coordinates.
io::TableColumns text_columns(const TextRows& rows, const ReadOptions& options) {
  const std::size_t count = rows.fields().size();
  if (count > kMostDimensions) {
    rows.fail("has " + std::to_string(count) + " coordinates; at most 16777216 are supported");
  }
  return io::choose_columns(rows.file(), options.columns, rows.names(), count);
}

/// Parses the coordinates of the row that `rows` is at.
template <class Scalar>
void parse_point(const TextRows& rows, const std::vector<std::size_t>& columns, Scalar* point) {
  for (const std::size_t at : columns) {
    const char* const wrong = io::parse(rows.fields()[at], *point++);
    if (wrong != nullptr) rows.fail_field(at, wrong);
  }
}

template <class Scalar>
void read_text_points(const std::filesystem::path& path, const ReadOptions& options,
                      const detail::Allocation<Scalar>& allocation) {
  TextRows rows(path);
  if (!rows.next()) rows.fail_file("has no points");
  const std::size_t fields = rows.fields().size();
  const std::uint64_t first_line = rows.line();
  const io::TableColumns columns = text_columns(rows, options);
  const int dimension = columns.dimension();
  Points<Scalar> points(dimension, std::max<Eigen::Index>(1, (1 << 20) / dimension));
  Eigen::Index count = 0;
  do {
    if (rows.fields().size() != fields) {
      rows.fail("has " + std::to_string(rows.fields().size()) + " coordinates, but line " +
                std::to_string(first_line) + " has " + std::to_string(fields) +
                "; all points need the same number");
    }
    if (count == kMostPoints) {
      rows.fail("is one point too many; at most 2147483647 are supported");
    }
    if (count == points.cols()) points.conservativeResize(Eigen::NoChange, 2 * count);
    parse_point(rows, columns.at, points.col(count).data());
    ++count;
  } while (rows.next());
  const PointsHeader header = {ScalarType::float64, dimension, static_cast<std::uint64_t>(count)};
  io::allocate(allocation, header) = points.leftCols(count);
}

/// What a file of vectors or particles holds, where no columns are asked for.
PointsHeader inspect_vectors(const std::filesystem::path& path, const std::string& extension,
                             const ReadOptions& options) {
  if (extension == ".gadget") return io::inspect_gadget_points(path);
  if (extension == ".hdf5") return io::inspect_hdf5_points(path);
  return io::inspect_vecs(path, options);
}

template <class Scalar>
PointsMap<Scalar> read_all_of(const std::filesystem::path& path, const std::string& extension,
                              const ReadOptions& options,
                              const detail::Allocation<Scalar>& allocation) {
  if (extension == ".gadget") return io::read_gadget_points(path, allocation);
  if (extension == ".hdf5") return io::read_hdf5_points(path, allocation);
  return io::read_vecs(path, options, allocation);
}

/// Those coordinates of vectors or particles that are asked for.
template <class Scalar>
void read_vectors(const std::filesystem::path& path, const std::string& extension,
                  const ReadOptions& options, const detail::Allocation<Scalar>& allocation) {
  const InputFile file(path);
  if (options.columns.empty()) {
    const auto points = read_all_of(path, extension, options, allocation);
    return io::check_finite(file, view_points(points), options.first_row);
  }
  Points<Scalar> all;
  const auto vectors = read_all_of(path, extension, options, detail::allocate_in(all));
  const auto columns =
      io::choose_columns(file, options.columns, {}, static_cast<std::size_t>(vectors.rows()));
  const PointsHeader header = {ScalarType::float32, columns.dimension(),
                               static_cast<std::uint64_t>(vectors.cols())};
  PointsMap<Scalar> chosen = io::allocate(allocation, header);
  chosen = vectors(columns.at, Eigen::all);
  io::check_finite(file, view_points(chosen), options.first_row);
}

template <class Scalar>
void write_npy_points(const std::filesystem::path& path, PointsView<Scalar> points) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  const auto count = static_cast<std::size_t>(points.count);
  io::OutputFile file(path);
  file.write(io::format_npy_header(sizeof(Scalar) == 4 ? "<f4" : "<f8", {count, dimension}));
  if (points.stride == points.dimension) {
    file.write(points.data, count * dimension * sizeof(Scalar));
  } else {
    for (Index p = 0; p < points.count; ++p) file.write(points[p], dimension * sizeof(Scalar));
  }
  file.commit();
}

}  // namespace

PointsHeader inspect_points(const std::filesystem::path& path, const ReadOptions& options) {
  const std::string extension = points_extension(path);
  if (extension == ".ply") return io::inspect_ply_points(path, options);
  if (extension == ".npy") return io::inspect_npy_points(path, options);
  if (io::is_vecs(path) || io::is_among(io::kParticleFiles, extension)) {
    PointsHeader header = inspect_vectors(path, extension, options);
    const auto columns = io::choose_columns(InputFile(path), options.columns, {},
                                            static_cast<std::size_t>(header.dimension));
    header.dimension = columns.dimension();
    if (!options.columns.empty()) header.box.clear();
    return header;
  }
  TextRows rows(path);
  if (!rows.next()) rows.fail_file("has no points");
  io::TableColumns columns = text_columns(rows, options);
  return {.scalar = ScalarType::float64,
          .dimension = columns.dimension(),
          .count = 1 + rows.count_lines(),
          .columns = std::move(columns.names),
          .left_out = std::move(columns.left_out),
          .unknown = columns.unknown,
          .reordered = columns.reordered};
}

namespace {

template <class Scalar>
void read_into(const std::filesystem::path& path, const ReadOptions& options,
               const detail::Allocation<Scalar>& allocation) {
  const std::string extension = points_extension(path);
  refuse_part(path, options, extension);
  if (extension == ".ply") return io::read_ply_points(path, options, allocation);
  if (extension == ".npy") return io::read_npy_points(path, options, allocation);
  if (io::is_vecs(path) || io::is_among(io::kParticleFiles, extension)) {
    return read_vectors(path, extension, options, allocation);
  }
  read_text_points(path, options, allocation);
}

}  // namespace

void detail::read_points(const std::filesystem::path& path, const ReadOptions& options,
                         Allocation<float> points) {
  read_into(path, options, points);
}

void detail::read_points(const std::filesystem::path& path, const ReadOptions& options,
                         Allocation<double> points) {
  read_into(path, options, points);
}

template <class Scalar>
void write_points(const std::filesystem::path& path, PointsView<Scalar> points) {
  require_data("points", points);
  const std::string extension = table_extension(path);
  require_finite(as_matrix(points), "is");  // what no reader takes is not written
  if (extension == ".npy") return write_npy_points(path, points);
  const char separator = extension == ".csv" ? ',' : ' ';
  io::OutputFile file(path);
  std::string text;
  for (Index p = 0; p < points.count; ++p) {
    for (int i = 0; i < points.dimension; ++i) {
      if (i > 0) text += separator;
      io::append(text, points[p][i]);
    }
    text += '\n';
    if (text.size() >= kBlock) {
      file.write(text);
      text.clear();
    }
  }
  file.write(text);
  file.commit();
}

std::vector<Index> read_indices(const std::filesystem::path& path) {
  std::vector<Index> values;
  if (table_extension(path, "whole numbers come from") != ".npy") {
    TextRows rows(path);
    while (rows.next()) {
      const std::string_view field = rows.fields().front();
      if (rows.fields().size() != 1) {
        rows.fail("has " + std::to_string(rows.fields().size()) +
                  " fields; one whole number a line is expected");
      }
      const char* const wrong = io::parse(field, values.emplace_back());
      if (wrong != nullptr) rows.fail(io::quoted(field) + " " + wrong);
    }
    if (values.empty()) rows.fail_file("has no numbers");
    return values;
  }
  InputFile file(path);
  const io::NpyHeader header = io::read_npy_header(file);
  const auto item = io::parse_npy_descr(header.descr);
  if (!item || item->type == io::NpyType::boolean) {
    file.fail("has dtype " + io::quoted(header.descr) + "; whole numbers are expected");
  }
  const bool column = header.shape.size() == 2 && header.shape[1] == 1;
  if (header.shape.size() != 1 && !column) {
    file.fail("has the shape " + io::shape_text(header.shape) + "; a vector is expected");
  }
  io::check_npy_size(file, header, item->bytes);
  if (header.shape[0] == 0) file.fail("has no numbers");
  values.reserve(header.shape[0]);
  io::read_npy_numbers(file, *item, header.shape[0], [&](auto number) {
    const char* const wrong = io::to_whole(number, values.emplace_back());
    if (wrong == nullptr) return;
    file.fail("row " + std::to_string(values.size() - 1) + ": " + text(number) + " " + wrong);
  });
  return values;
}

void write_owners(const std::filesystem::path& path, std::span<const Index> owners) {
  static_assert(sizeof(Index) == 4);
  if (owners.empty()) throw InvalidInput("owners: there are none");
  const std::string extension = table_extension(path);
  io::OutputFile file(path);
  if (extension == ".npy") {
    file.write(io::format_npy_header("<i4", {owners.size()}));
    file.write(owners.data(), owners.size_bytes());
  } else {
    std::string text;
    for (const Index owner : owners) {
      io::append(text, owner);
      text += '\n';
      if (text.size() >= kBlock) {
        file.write(text);
        text.clear();
      }
    }
    file.write(text);
  }
  file.commit();
}

void write_text(const std::filesystem::path& path, std::string_view text) {
  io::OutputFile file(path);
  file.write(text);
  file.commit();
}

template CCVT_EXPORT void write_points<float>(const std::filesystem::path&, PointsView<float>);
template CCVT_EXPORT void write_points<double>(const std::filesystem::path&, PointsView<double>);

}  // namespace ccvt
