#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <type_traits>
#include <vector>

#include "ccvt/io.h"
#include "io/input_file.h"
#include "io/npy.h"
#include "io/output_file.h"
#include "io/ply.h"
#include "io/text.h"
#include "io/vecs.h"

namespace ccvt {

namespace {

using io::InputFile;
using io::NpyHeader;
using io::TextRows;

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr std::uint64_t kMostPoints = std::numeric_limits<Index>::max();
constexpr std::uint64_t kMostDimensions = std::uint64_t{1} << 24;

enum class Format { npy, csv, txt, vecs };

Format format_of(const std::filesystem::path& path) {
  const std::string extension = io::extension_of(path);
  if (extension == ".npy") return Format::npy;
  if (extension == ".csv") return Format::csv;
  if (extension == ".txt") return Format::txt;
  throw InvalidInput(path.string() + ": unknown extension " + io::quoted(extension) +
                     "; points and owners go into .npy, .csv or .txt");
}

/// PLY is read, not written.
bool is_ply(const std::filesystem::path& path) { return io::extension_of(path) == ".ply"; }

Format format_to_read(const std::filesystem::path& path) {
  return io::is_vecs(path) ? Format::vecs : format_of(path);
}

/// Checks all that the header says; the data behind it is then as long as it has to be.
PointsHeader check_npy_points(const InputFile& file, const NpyHeader& header) {
  const bool bytes = header.descr == "|u1";
  if (header.descr != "<f4" && header.descr != "<f8" && !bytes) {
    file.fail("has dtype " + io::quoted(header.descr) +
              "; points must be float32 ('<f4'), float64 ('<f8') or uint8 ('|u1')");
  }
  if (header.shape.size() != 2) {
    file.fail("has the shape " + io::shape_text(header.shape) +
              "; points need two extents: (points, dimensions)");
  }
  const bool narrow = header.descr != "<f8";
  io::check_npy_size(file, header, bytes ? 1 : narrow ? 4 : 8);
  const std::uint64_t count = header.shape[0];
  const std::uint64_t dimension = header.shape[1];
  if (count == 0) file.fail("has the shape " + io::shape_text(header.shape) + ": no points");
  if (dimension == 0)
    file.fail("has the shape " + io::shape_text(header.shape) + ": no dimensions");
  if (count > kMostPoints || dimension > kMostDimensions) {
    file.fail("has the shape " + io::shape_text(header.shape) +
              "; at most 2147483647 points and 16777216 dimensions are supported");
  }
  return {narrow ? ScalarType::float32 : ScalarType::float64, static_cast<int>(dimension), count};
}

[[noreturn]] void fail_coordinate(const InputFile& file, Eigen::Index row, Eigen::Index column,
                                  double value, const char* rule) {
  std::string text;
  io::append(text, value);
  file.fail("row " + std::to_string(row) + ", column " + std::to_string(column) + ": " + text +
            " " + rule);
}

template <class Scalar>
void check_finite(const InputFile& file, const Points<Scalar>& points) {
  for (Eigen::Index row = 0; row < points.cols(); ++row) {
    if (points.col(row).allFinite()) continue;
    Eigen::Index column = 0;
    while (std::isfinite(points(column, row))) ++column;
    fail_coordinate(file, row, column, static_cast<double>(points(column, row)),
                    "is not finite; coordinates must be finite");
  }
}

template <class Stored, class Scalar>
void convert_data(InputFile& file, Points<Scalar>& points) {
  std::vector<Stored> block(kBlock);
  const auto total = static_cast<std::size_t>(points.size());
  for (std::size_t done = 0; done < total;) {
    const std::size_t count = std::min(kBlock, total - done);
    file.read(block.data(), count * sizeof(Stored));
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = static_cast<Scalar>(block[i]);
      if (std::isfinite(static_cast<double>(block[i])) && !std::isfinite(value)) {
        const auto at = static_cast<Eigen::Index>(done + i);
        fail_coordinate(file, at / points.rows(), at % points.rows(), static_cast<double>(block[i]),
                        "is out of the range of float32");
      }
      points.data()[done + i] = value;
    }
    done += count;
  }
}

template <class Scalar>
Points<Scalar> read_npy_points(const std::filesystem::path& path) {
  InputFile file(path);
  const NpyHeader npy = io::read_npy_header(file);
  const PointsHeader header = check_npy_points(file, npy);
  Points<Scalar> points(header.dimension, static_cast<Eigen::Index>(header.count));
  const auto size = static_cast<std::size_t>(points.size());
  const bool narrow = header.scalar == ScalarType::float32;
  if (npy.descr == "|u1") {
    convert_data<std::uint8_t>(file, points);
  } else if (narrow == std::is_same_v<Scalar, float>) {
    file.read(points.data(), size * sizeof(Scalar));
  } else if (narrow) {
    convert_data<float>(file, points);
  } else {
    convert_data<double>(file, points);
  }
  check_finite(file, points);
  return points;
}

template <class Scalar>
Points<Scalar> read_text_points(const std::filesystem::path& path) {
  TextRows rows(path);
  Points<Scalar> points;
  Eigen::Index count = 0;
  std::uint64_t first_line = 0;
  while (rows.next()) {
    const auto dimension = static_cast<Eigen::Index>(rows.fields().size());
    if (count == 0) {
      points.resize(dimension, std::max<Eigen::Index>(1, (1 << 20) / dimension));
      first_line = rows.line();
    }
    if (dimension != points.rows()) {
      rows.fail("has " + std::to_string(dimension) + " coordinates, but line " +
                std::to_string(first_line) + " has " + std::to_string(points.rows()) +
                "; all points need the same number");
    }
    if (static_cast<std::uint64_t>(count) == kMostPoints) {
      rows.fail("is one point too many; at most 2147483647 are supported");
    }
    if (count == points.cols()) points.conservativeResize(Eigen::NoChange, 2 * count);
    for (Eigen::Index i = 0; i < dimension; ++i) {
      const std::string_view field = rows.fields()[static_cast<std::size_t>(i)];
      const char* const wrong = io::parse(field, points(i, count));
      if (wrong != nullptr) {
        rows.fail("field " + std::to_string(i + 1) + ": " + io::quoted(field) + " " + wrong);
      }
    }
    ++count;
  }
  if (count == 0) rows.fail_file("has no points");
  points.conservativeResize(Eigen::NoChange, count);
  return points;
}

template <class Scalar>
void write_npy_points(const std::filesystem::path& path, PointsView<Scalar> points) {
  const auto dimension = static_cast<std::size_t>(points.dimension);
  io::OutputFile file(path);
  file.write(io::format_npy_header(sizeof(Scalar) == 4 ? "<f4" : "<f8",
                                   {static_cast<std::uint64_t>(points.count), dimension}));
  if (points.stride == points.dimension) {
    file.write(points.data, static_cast<std::size_t>(points.count) * dimension * sizeof(Scalar));
  } else {
    for (Index p = 0; p < points.count; ++p) file.write(points[p], dimension * sizeof(Scalar));
  }
  file.commit();
}

}  // namespace

PointsHeader inspect_points(const std::filesystem::path& path) {
  if (is_ply(path)) return io::inspect_ply_points(path);
  const Format format = format_to_read(path);
  if (format == Format::vecs) return io::inspect_vecs(path);
  if (format == Format::npy) {
    InputFile file(path);
    return check_npy_points(file, io::read_npy_header(file));
  }
  TextRows rows(path);
  if (!rows.next()) rows.fail_file("has no points");
  const std::size_t dimension = rows.fields().size();
  if (dimension > kMostDimensions) {
    rows.fail("has " + std::to_string(dimension) + " coordinates; at most 16777216 are supported");
  }
  return {ScalarType::float64, static_cast<int>(dimension), 1 + rows.count_lines()};
}

template <class Scalar>
Points<Scalar> read_points(const std::filesystem::path& path) {
  if (is_ply(path)) return io::read_ply_points<Scalar>(path);
  const Format format = format_to_read(path);
  if (format == Format::vecs) {
    Points<Scalar> points = io::read_vecs<Scalar>(path);
    check_finite(InputFile(path), points);
    return points;
  }
  return format == Format::npy ? read_npy_points<Scalar>(path) : read_text_points<Scalar>(path);
}

template <class Scalar>
void write_points(const std::filesystem::path& path, PointsView<Scalar> points) {
  const Format format = format_of(path);
  if (format == Format::npy) return write_npy_points(path, points);
  const char separator = format == Format::csv ? ',' : ' ';
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
  if (format_of(path) != Format::npy) {
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
  const NpyHeader header = io::read_npy_header(file);
  if (header.descr != "<i4" && header.descr != "<i8") {
    file.fail("has dtype " + io::quoted(header.descr) +
              "; int32 ('<i4') or int64 ('<i8') is expected");
  }
  if (header.shape.size() != 1) {
    file.fail("has the shape " + io::shape_text(header.shape) + "; a vector is expected");
  }
  io::check_npy_size(file, header, header.descr == "<i4" ? 4 : 8);
  if (header.shape[0] == 0) file.fail("has no numbers");
  values.resize(header.shape[0]);
  if (header.descr == "<i4") {
    file.read(values.data(), values.size() * sizeof(Index));
    return values;
  }
  std::vector<std::int64_t> block(kBlock);
  for (std::size_t done = 0; done < values.size(); done += block.size()) {
    block.resize(std::min(kBlock, values.size() - done));
    file.read(block.data(), block.size() * sizeof(std::int64_t));
    for (std::size_t i = 0; i < block.size(); ++i) {
      values[done + i] = static_cast<Index>(block[i]);
      if (values[done + i] != block[i]) {
        file.fail("row " + std::to_string(done + i) + ": " + std::to_string(block[i]) +
                  " does not fit 32 bits");
      }
    }
  }
  return values;
}

void write_owners(const std::filesystem::path& path, std::span<const Index> owners) {
  static_assert(sizeof(Index) == 4);
  const Format format = format_of(path);
  io::OutputFile file(path);
  if (format == Format::npy) {
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

template CCVT_EXPORT Points<float> read_points<float>(const std::filesystem::path&);
template CCVT_EXPORT Points<double> read_points<double>(const std::filesystem::path&);
template CCVT_EXPORT void write_points<float>(const std::filesystem::path&, PointsView<float>);
template CCVT_EXPORT void write_points<double>(const std::filesystem::path&, PointsView<double>);

}  // namespace ccvt
