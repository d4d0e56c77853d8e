#include "ccvt/point_cloud.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <utility>

#include "io/columns.h"
#include "io/formats.h"
#include "io/output_file.h"
#include "io/records.h"
#include "io/text.h"
#include "number_text.h"

namespace ccvt {
namespace io {
namespace {

using Records = PointCloud::Records;

constexpr std::size_t kBlock = std::size_t{1} << 16;
/// Ends each field of a text's records: no field has one.
constexpr char kFieldEnd = '\n';

double parse_field(const TextRows& rows, std::size_t at, bool any) {
  double value = 0;
  const std::string_view field = rows.fields()[at];
  const char* const wrong = parse(field, value);
  if (wrong == nullptr || (any && !std::isfinite(value))) return value;
  rows.fail_field(at, wrong);
}

/// Numbers one after the other, as columns.
Columns<double> in_columns(int dimension, const std::vector<double>& numbers) {
  Columns<double> columns(dimension, std::ssize(numbers) / std::max(dimension, 1));
  std::copy(numbers.begin(), numbers.end(), columns.data());
  return columns;
}

void append_count(std::string& bytes, Index count, PlyFile::Encoding encoding) {
  if (encoding == PlyFile::Encoding::ascii) {
    append(bytes, count);
    bytes += '\n';
    return;
  }
  static_assert(std::endian::native == std::endian::little);
  std::array<char, sizeof(Index)> raw{};
  std::memcpy(raw.data(), &count, sizeof(Index));
  if (encoding == PlyFile::Encoding::big) std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

const char* name_of(PlyType type) {
  static constexpr std::array<const char*, 8> names = {"char", "uchar", "short", "ushort",
                                                       "int",  "uint",  "float", "double"};
  return names.at(static_cast<std::size_t>(type));
}

std::string ply_header_text(const Records& records, std::size_t vertices) {
  std::string text = "ply\nformat ";
  text += records.encoding == PlyFile::Encoding::ascii    ? "ascii"
          : records.encoding == PlyFile::Encoding::little ? "binary_little_endian"
                                                          : "binary_big_endian";
  text += " 1.0\n";
  for (const std::string& comment : records.comments) text += comment + '\n';
  text += "element vertex " + std::to_string(vertices) + '\n';
  std::vector<std::string> names;
  for (const PlyProperty& property : records.properties) {
    text += "property ";
    if (property.list) text += std::string("list ") + name_of(property.length) + ' ';
    text += name_of(property.type) + (' ' + property.name) + '\n';
    names.push_back(property.name);
  }
  return text + "property int " + count_name(names) + "\nend_header\n";
}

/// The record of a point of which nothing is known but where it is.
std::string plain_record(const PointCloud& cloud, Index point) {
  std::string bytes;
  for (std::ptrdiff_t d = 0; d < cloud.points.rows(); ++d) {
    const double x = cloud.points(d, point);
    std::array<char, sizeof(double)> raw{};
    std::size_t size = sizeof(double);
    if (cloud.scalar == ScalarType::float32) {
      const auto narrow = static_cast<float>(x);
      size = sizeof narrow;
      std::memcpy(raw.data(), &narrow, size);
    } else {
      std::memcpy(raw.data(), &x, size);
    }
    bytes.append(raw.data(), size);
  }
  return bytes;
}

/// The header of points of which nothing is known but where they are.
Records plain_records(const PointCloud& cloud) {
  Records records;
  records.encoding = PlyFile::Encoding::little;
  const bool narrow = cloud.scalar == ScalarType::float32;
  for (std::ptrdiff_t d = 0; d < cloud.points.rows(); ++d) {
    PlyProperty property;
    property.type = narrow ? PlyType::float32 : PlyType::float64;
    property.name = "xyz"[d];
    records.properties.push_back(std::move(property));
  }
  return records;
}

/// Writes head, and then what row(k, text) appends for each.
template <class Row>
void write_rows(const std::filesystem::path& path, std::string text, std::size_t rows,
                const Row& row) {
  OutputFile file(path);
  for (std::size_t k = 0; k < rows; ++k) {
    row(k, text);
    if (text.size() < kBlock) continue;
    file.write(text);
    text.clear();
  }
  file.write(text);
  file.commit();
}

void write_ply(const std::filesystem::path& path, const PointCloud& cloud,
               std::span<const Index> chosen, std::span<const Index> counts) {
  const bool whole = cloud.records != nullptr && cloud.records->kind == Records::Kind::ply;
  if (!whole && cloud.points.rows() > 3) {
    throw InvalidInput(path.string() + ": points of " + std::to_string(cloud.points.rows()) +
                       " dimensions go into .csv, .txt or .npy");
  }
  const Records plain = whole ? Records() : plain_records(cloud);
  const Records& records = whole ? *cloud.records : plain;
  write_rows(path, ply_header_text(records, chosen.size()), chosen.size(),
             [&](std::size_t k, std::string& bytes) {
               bytes +=
                   whole ? std::string(records.record(chosen[k])) : plain_record(cloud, chosen[k]);
               append_count(bytes, counts[k], records.encoding);
             });
}

/// Fields, and one more.
void append_row(std::string& text, std::string_view fields, const std::string& last,
                char separator) {
  while (!fields.empty()) {
    const std::size_t end = fields.find(kFieldEnd);
    append_field(text, fields.substr(0, end), separator);
    text += separator;
    fields.remove_prefix(end + 1);
  }
  text += last + '\n';
}

void write_text(const std::filesystem::path& path, char separator, const PointCloud& cloud,
                std::span<const Index> chosen, std::span<const Index> counts) {
  const bool whole = cloud.records != nullptr && cloud.records->kind == Records::Kind::text;
  std::vector<std::string> names;
  if (whole) {
    names = cloud.records->names;
  } else {
    for (std::ptrdiff_t d = 0; d < cloud.points.rows(); ++d) {
      names.push_back(cloud.points.rows() <= 3 ? std::string(1, "xyz"[d]) : concat("x", d));
    }
  }
  std::string head;
  for (const std::string& name : names) {
    append_field(head, name, separator);
    head += separator;
  }
  if (!names.empty()) head += count_name(names) + '\n';
  write_rows(path, head, chosen.size(), [&](std::size_t k, std::string& text) {
    std::string fields;
    if (whole) {
      fields = cloud.records->record(chosen[k]);
    } else {
      for (std::ptrdiff_t d = 0; d < cloud.points.rows(); ++d) {
        const double x = cloud.points(d, chosen[k]);
        cloud.scalar == ScalarType::float32 ? append(fields, static_cast<float>(x))
                                            : append(fields, x);
        fields += kFieldEnd;
      }
    }
    append_row(text, fields, std::to_string(counts[k]), separator);
  });
}

void write_npy(const std::filesystem::path& path, const PointCloud& cloud,
               std::span<const Index> chosen) {
  Columns<double> points(cloud.points.rows(), std::ssize(chosen));
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    points.eigen().col(static_cast<Eigen::Index>(k)) = cloud.points.col(chosen[k]);
  }
  if (cloud.scalar == ScalarType::float64) return write_points(path, points);
  write_points(path, Columns<float>(points.eigen().cast<float>()));
}

}  // namespace

std::string count_name(const std::vector<std::string>& names) {
  std::string name = "count";
  for (int k = 2; std::find(names.begin(), names.end(), name) != names.end(); ++k) {
    name = "count_" + std::to_string(k);
  }
  return name;
}

PointCloud read_text_cloud(const std::filesystem::path& path, const ReadOptions& options) {
  TextRows rows(path);
  if (!rows.next()) rows.fail_file("has no points");
  const std::size_t fields = rows.fields().size();
  const std::uint64_t first_line = rows.line();
  auto records = std::make_shared<Records>();
  records->kind = Records::Kind::text;
  records->names = rows.names();
  const TableColumns columns = choose_columns(rows.file(), options.columns, records->names, fields);
  std::vector<std::size_t> normal_columns;
  if (columns.at.size() == 3) {
    normal_columns = find_normals(records->names, [&](std::size_t column) {
      return std::count(columns.at.begin(), columns.at.end(), column) == 0;
    });
  }
  std::vector<double> points;
  std::vector<double> normals;
  PointCloud cloud;
  do {
    if (rows.fields().size() != fields) {
      rows.fail("has " + std::to_string(rows.fields().size()) + " fields, but line " +
                std::to_string(first_line) + " has " + std::to_string(fields) +
                "; all points need the same number");
    }
    if (records->first.size() == std::size_t{std::numeric_limits<Index>::max()}) {
      rows.fail("is one point too many; at most 2147483647 are supported");
    }
    records->first.push_back(records->bytes.size());
    for (const std::string_view text : rows.texts()) (records->bytes += text) += kFieldEnd;
    for (const std::size_t at : columns.at) points.push_back(parse_field(rows, at, false));
    std::array<double, 3> normal{};
    for (std::size_t k = 0; k < normal_columns.size(); ++k) {
      normal.at(k) = parse_field(rows, normal_columns[k], true);
    }
    if (normal_columns.empty()) continue;
    const bool known =
        std::all_of(normal.begin(), normal.end(), [](double x) { return std::isfinite(x); });
    if (!known) ++cloud.unknown_normals;
    for (const double x : normal) normals.push_back(known ? x : 0);
  } while (rows.next());
  records->first.push_back(records->bytes.size());
  cloud.points = in_columns(columns.dimension(), points);
  if (!normal_columns.empty()) cloud.normals = in_columns(3, normals);
  for (std::size_t k = 0; k < records->names.size(); ++k) {
    const auto among = [k](const std::vector<std::size_t>& at) {
      return std::find(at.begin(), at.end(), k) != at.end();
    };
    if (!among(columns.at) && !among(normal_columns)) cloud.kept.push_back(records->names[k]);
  }
  cloud.records = std::move(records);
  return cloud;
}

}  // namespace io

PointCloud read_point_cloud(const std::filesystem::path& path, const ReadOptions& options) {
  const std::string extension = io::extension_of(path);
  if (extension == ".ply") return io::read_ply_cloud(path, options);
  if (extension == ".csv" || extension == ".txt") return io::read_text_cloud(path, options);
  PointCloud cloud;
  cloud.scalar = inspect_points(path, options).scalar;
  cloud.points = read_points<double>(path, options);
  return cloud;
}

void write_point_cloud(const std::filesystem::path& path, const PointCloud& cloud,
                       std::span<const Index> chosen, std::span<const Index> counts) {
  if (counts.size() != chosen.size()) {
    throw InvalidInput(concat("counts: there are ", counts.size(), " for ", chosen.size(),
                              " points; needs one for each"));
  }
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    if (chosen[k] >= 0 && chosen[k] < cloud.points.cols()) continue;
    throw InvalidInput(
        concat("chosen[", k, "] is ", chosen[k], ": it must be in 0..", cloud.points.cols() - 1));
  }
  const std::string extension = io::extension_of(path);
  if (extension == ".ply") return io::write_ply(path, cloud, chosen, counts);
  if (extension == ".csv") return io::write_text(path, ',', cloud, chosen, counts);
  if (extension == ".txt") return io::write_text(path, ' ', cloud, chosen, counts);
  if (extension == ".npy") return io::write_npy(path, cloud, chosen);
  throw InvalidInput(path.string() + ": unknown extension " + io::quoted(extension) +
                     "; chosen points go into " + io::list_of(io::kThinFiles, " or "));
}

}  // namespace ccvt
