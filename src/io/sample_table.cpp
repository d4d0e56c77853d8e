#include "io/sample_table.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <numeric>
#include <string_view>
#include <type_traits>

#include "io/formats.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "io/text.h"

namespace ccvt::io {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kBlock = std::size_t{1} << 16;
constexpr double kAny = std::numeric_limits<double>::infinity();

template <class Value>
void append_little(std::string& bytes, Value value) {
  std::array<char, sizeof(Value)> raw{};
  std::memcpy(raw.data(), &value, sizeof(Value));
  bytes.append(raw.data(), raw.size());
}

template <class Value>
void append_big(std::string& bytes, Value value) {
  std::array<char, sizeof(Value)> raw{};
  std::memcpy(raw.data(), &value, sizeof(Value));
  std::reverse(raw.begin(), raw.end());
  bytes.append(raw.data(), raw.size());
}

/// Whether float32 moves a site by more than a thousandth of the mean radius, or along an axis by
/// what could take it across a face between a cell of density 0 and its own: a share of the extent
/// of all along that axis, if they have one.
bool needs_double(const SampleTable& table) {
  const auto sites = table.sites.eigen();
  double radius = 0;
  const double count = view_points(table.sites).count;
  for (const double r : table.radii) radius += r / count;
  for (Eigen::Index d = 0; d < sites.rows(); ++d) {
    const auto along = sites.row(d);
    const double extent = along.maxCoeff() - along.minCoeff();
    const double most = std::min(1e-3 * radius, extent > 0 ? 0x1p-22 * extent : kAny);
    if (((along - along.cast<float>().cast<double>()).array().abs() > most).any()) return true;
  }
  return false;
}

/// Whether float32 makes a number infinite, or loses digits of one near 0.
bool leaves_float(const SampleTable& table) {
  using Limits = std::numeric_limits<float>;
  return std::any_of(table.columns.begin(), table.columns.end(), [](const SampleColumn& column) {
    return std::any_of(column.reals.begin(), column.reals.end(), [](double x) {
      const double size = std::abs(x);
      return size > Limits::max() || (size > 0 && size < Limits::min());
    });
  });
}

/// The coordinates of all sites, one site behind the other, with 0 for those from the sites' own
/// dimension up to `rows`.
template <class Scalar>
std::vector<Scalar> coordinates(const SampleTable& table, std::size_t rows) {
  const auto own = static_cast<std::size_t>(table.sites.rows());
  const auto count = static_cast<std::size_t>(table.sites.cols());
  std::vector<Scalar> result(rows * count);
  for (std::size_t s = 0; s < count; ++s) {
    std::transform(table.sites.data() + s * own, table.sites.data() + (s + 1) * own,
                   result.data() + s * rows, [](double x) { return static_cast<Scalar>(x); });
  }
  return result;
}

/// Calls real(x) or whole(i) for each number of the columns of a sample.
template <class Scalar, class Real, class Whole>
void visit_sample(const SampleTable& table, std::size_t sample, const Real& real,
                  const Whole& whole) {
  for (const SampleColumn& column : table.columns) {
    const std::size_t parts = column.components();
    for (std::size_t k = parts * sample; k < parts * (sample + 1); ++k) {
      if (column.reals.empty()) {
        whole(column.integers[k]);
      } else {
        real(static_cast<Scalar>(column.reals[k]));
      }
    }
  }
}

/// Writes what item(s, bytes) appends for each of the samples, and `bytes` before it.
template <class Item>
void write_items(const std::filesystem::path& path, std::string bytes, std::ptrdiff_t count,
                 const Item& item) {
  OutputFile file(path);
  for (std::size_t s = 0; s < static_cast<std::size_t>(count); ++s) {
    item(s, bytes);
    if (bytes.size() < kBlock) continue;
    file.write(bytes);
    bytes.clear();
  }
  file.write(bytes);
  file.commit();
}

template <class Scalar>
void write_ply(const std::filesystem::path& path, const SampleTable& table) {
  const std::string real = sizeof(Scalar) == 4 ? "property float " : "property double ";
  std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                       std::to_string(table.sites.cols()) + "\n" + real + "x\n" + real + "y\n" +
                       real + "z\n";
  for (const SampleColumn& column : table.columns) {
    for (const std::string& name : column.columns) {
      header += (column.reals.empty() ? "property int " : real) + name + "\n";
    }
  }
  const std::vector<Scalar> sites = coordinates<Scalar>(table, 3);
  write_items(path, header + "end_header\n", table.sites.cols(),
              [&](std::size_t s, std::string& bytes) {
                for (std::size_t d = 0; d < 3; ++d) append_little(bytes, sites[3 * s + d]);
                visit_sample<Scalar>(
                    table, s, [&](Scalar x) { append_little(bytes, x); },
                    [&](Index i) { append_little(bytes, i); });
              });
}

std::string base64(std::span<const std::byte> bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (k < count ? std::to_integer<unsigned>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? digits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

/// One array of a VTP file.
template <class Number>
void write_array(OutputFile& file, const std::string& name, std::size_t components,
                 std::span<const Number> numbers) {
  const std::string type = std::is_same_v<Number, float>    ? "Float32"
                           : std::is_same_v<Number, double> ? "Float64"
                           : sizeof(Number) == 4            ? "Int32"
                                                            : "Int64";
  std::string bytes;
  const std::uint64_t size = numbers.size_bytes();
  append_little(bytes, size);
  for (const Number number : numbers) append_little(bytes, number);
  const auto quoted = [](const std::string& text) { return '"' + text + '"'; };
  file.write("<DataArray type=" + quoted(type) + " Name=" + quoted(name) + " NumberOfComponents=" +
             quoted(std::to_string(components)) + " format=" + quoted("binary") + '>' +
             base64(std::as_bytes(std::span(bytes))) + "</DataArray>\n");
}

template <class Scalar>
void write_vtp(const std::filesystem::path& path, const SampleTable& table) {
  const std::string count = std::to_string(table.sites.cols());
  OutputFile file(path);
  file.write(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      count + "\" NumberOfVerts=\"" + count +
      "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
      "<PointData Scalars=\"radius\">\n");
  for (const SampleColumn& column : table.columns) {
    if (column.reals.empty()) {
      write_array<Index>(file, column.name, column.components(), column.integers);
    } else {
      const std::vector<Scalar> reals(column.reals.begin(), column.reals.end());
      write_array<Scalar>(file, column.name, column.components(), reals);
    }
  }
  file.write("</PointData>\n<Points>\n");
  write_array<Scalar>(file, "Points", 3, coordinates<Scalar>(table, 3));
  file.write("</Points>\n<Verts>\n");
  std::vector<std::int64_t> numbers(static_cast<std::size_t>(table.sites.cols()));
  std::iota(numbers.begin(), numbers.end(), 0);
  write_array<std::int64_t>(file, "connectivity", 1, numbers);
  std::iota(numbers.begin(), numbers.end(), 1);
  write_array<std::int64_t>(file, "offsets", 1, numbers);
  file.write("</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n");
  file.commit();
}

/// The legacy format: numbers are big endian.
template <class Scalar>
void write_vtk(const std::filesystem::path& path, const SampleTable& table) {
  const Index sites = view_points(table.sites).count;
  const std::string count = std::to_string(sites);
  const std::string real = sizeof(Scalar) == 4 ? "float" : "double";
  std::string bytes =
      "# vtk DataFile Version 3.0\nccvt samples\nBINARY\nDATASET POLYDATA\nPOINTS " + count + " " +
      real + "\n";
  for (const Scalar x : coordinates<Scalar>(table, 3)) append_big(bytes, x);
  bytes += "\nVERTICES " + count + " " + std::to_string(2 * table.sites.cols()) + "\n";
  for (Index s = 0; s < sites; ++s) {
    append_big(bytes, std::int32_t{1});
    append_big(bytes, s);
  }
  bytes += "\nPOINT_DATA " + count + "\n";
  for (const SampleColumn& column : table.columns) {
    bytes += "SCALARS " + column.name + (column.reals.empty() ? " int " : " " + real + " ") +
             std::to_string(column.components()) + "\nLOOKUP_TABLE default\n";
    for (const Index number : column.integers) append_big(bytes, number);
    for (const double number : column.reals) append_big(bytes, static_cast<Scalar>(number));
    bytes += "\n";
  }
  OutputFile file(path);
  file.write(bytes);
  file.commit();
}

template <class Scalar>
void write_text_samples(const std::filesystem::path& path, char separator,
                        const SampleTable& table) {
  const auto dimension = static_cast<std::size_t>(table.sites.rows());
  std::string header;
  for (std::size_t d = 0; d < dimension; ++d) {
    if (d > 0) header += separator;
    header += dimension <= 3 ? std::string(1, "xyz"[d]) : "x" + std::to_string(d);
  }
  for (const SampleColumn& column : table.columns) {
    for (const std::string& name : column.columns) header += separator + name;
  }
  const std::vector<Scalar> sites = coordinates<Scalar>(table, dimension);
  write_items(path, header + "\n", table.sites.cols(), [&](std::size_t s, std::string& text) {
    const auto add = [&](auto number) {
      append(text, number);
      text += separator;
    };
    for (std::size_t d = 0; d < dimension; ++d) add(sites[s * dimension + d]);
    visit_sample<Scalar>(table, s, add, add);
    text.back() = '\n';
  });
}

template <class Scalar>
void write_as(const std::filesystem::path& path, const SampleTable& table) {
  const std::string extension = extension_of(path);
  if (extension == ".csv") return write_text_samples<Scalar>(path, ',', table);
  if (extension == ".txt") return write_text_samples<Scalar>(path, ' ', table);
  if (extension == ".ply") return write_ply<Scalar>(path, table);
  if (extension == ".vtp") return write_vtp<Scalar>(path, table);
  if (extension == ".vtk") return write_vtk<Scalar>(path, table);
  throw InvalidInput(path.string() + ": unknown extension " + io::quoted(extension) +
                     "; samples go into " + list_of(kSampleFiles, " or "));
}

void check(const SampleTable& table) {
  const auto sites = static_cast<std::size_t>(table.sites.cols());
  if (sites == 0 || table.sites.rows() == 0) throw InvalidInput("samples: there are none");
  for (const SampleColumn& column : table.columns) {
    const std::size_t numbers = column.reals.size() + column.integers.size();
    if (numbers == sites * column.components()) continue;
    throw InvalidInput("samples: " + std::to_string(sites) + " sites have " +
                       std::to_string(numbers) + " numbers in the column " + column.name +
                       "; needs " + std::to_string(sites * column.components()));
  }
}

}  // namespace

void write_sample_table(const std::filesystem::path& path, const SampleTable& table) {
  check(table);
  const std::string extension = extension_of(path);
  if (extension == ".npy") return write_points(path, table.sites);
  const bool text = extension == ".csv" || extension == ".txt";
  if (!text && table.sites.rows() > 3) {
    throw InvalidInput(path.string() + ": samples of " + std::to_string(table.sites.rows()) +
                       " dimensions go into .csv, .txt or .npy");
  }
  const bool wide =
      table.scalar == ScalarType::float64 || needs_double(table) || leaves_float(table);
  wide ? write_as<double>(path, table) : write_as<float>(path, table);
}

}  // namespace ccvt::io
