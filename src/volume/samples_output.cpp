#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "ccvt/volume.h"
#include "io/formats.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "io/text.h"

namespace ccvt {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t kBlock = std::size_t{1} << 16;

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

/// A coordinate; 0 beyond the dimensions that the sites have.
template <class Scalar>
Scalar coordinate(const VolumeSamples& samples, Eigen::Index site, Eigen::Index d) {
  return d < samples.sites.rows() ? static_cast<Scalar>(samples.sites(d, site)) : Scalar{0};
}

/// Whether float32 moves a site by more than a thousandth of the mean radius, or of the extent of
/// all by what could take it across a face between a cell of density 0 and its own.
bool needs_double(const VolumeSamples& samples) {
  const auto sites = samples.sites.eigen();
  double radius = 0;
  for (const double r : samples.radii) radius += r / static_cast<double>(samples.radii.size());
  const double extent = (sites.rowwise().maxCoeff() - sites.rowwise().minCoeff()).maxCoeff();
  const double most = std::min(1e-3 * radius, 0x1p-22 * extent);
  return ((sites - sites.cast<float>().cast<double>()).array().abs() > most).any();
}

template <class Scalar>
void write_ply(const std::filesystem::path& path, const VolumeSamples& samples) {
  const std::string real = sizeof(Scalar) == 4 ? "property float " : "property double ";
  const Eigen::Index sites = samples.sites.cols();
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(sites) + "\n" + real + "x\n" + real + "y\n" + real + "z\n" +
                      real + "radius\nproperty int capacity\n" + real + "weight\nend_header\n";
  io::OutputFile file(path);
  for (Eigen::Index s = 0; s < sites; ++s) {
    const auto i = static_cast<std::size_t>(s);
    for (Eigen::Index d = 0; d < 3; ++d) append_little(bytes, coordinate<Scalar>(samples, s, d));
    append_little(bytes, static_cast<Scalar>(samples.radii[i]));
    append_little(bytes, samples.capacities[i]);
    append_little(bytes, static_cast<Scalar>(samples.weights[i]));
    if (bytes.size() >= kBlock) {
      file.write(bytes);
      bytes.clear();
    }
  }
  file.write(bytes);
  file.commit();
}

std::string base64(std::string_view bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8U | (k < count ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? digits[group >> (18 - 6 * k) & 63U] : '=';
    }
  }
  return text;
}

/// One array of a VTP file: count(s) numbers, of which value(i) is the i-th.
template <class Value>
void write_array(io::OutputFile& file, const char* name, int components, Eigen::Index count,
                 Value&& value) {
  using Number = std::decay_t<decltype(value(Eigen::Index{0}))>;
  const std::string type = std::is_same_v<Number, float>    ? "Float32"
                           : std::is_same_v<Number, double> ? "Float64"
                           : sizeof(Number) == 4            ? "Int32"
                                                            : "Int64";
  std::string bytes;
  append_little(bytes, static_cast<std::uint64_t>(count) * sizeof(Number));
  for (Eigen::Index i = 0; i < count; ++i) append_little(bytes, value(i));
  const auto quoted = [](const std::string& text) { return '"' + text + '"'; };
  file.write("<DataArray type=" + quoted(type) + " Name=" + quoted(name) +
             " NumberOfComponents=" + quoted(std::to_string(components)) +
             " format=" + quoted("binary") + '>' + base64(bytes) + "</DataArray>\n");
}

template <class Scalar>
void write_vtp(const std::filesystem::path& path, const VolumeSamples& samples) {
  const Eigen::Index sites = samples.sites.cols();
  const std::string count = std::to_string(sites);
  const auto at = [](const auto& values, Eigen::Index i) {
    return values[static_cast<std::size_t>(i)];
  };
  io::OutputFile file(path);
  file.write(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      count + "\" NumberOfVerts=\"" + count +
      "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
      "<PointData Scalars=\"radius\">\n");
  write_array(file, "radius", 1, sites,
              [&](Eigen::Index i) { return static_cast<Scalar>(at(samples.radii, i)); });
  write_array(file, "capacity", 1, sites,
              [&](Eigen::Index i) { return at(samples.capacities, i); });
  write_array(file, "weight", 1, sites,
              [&](Eigen::Index i) { return static_cast<Scalar>(at(samples.weights, i)); });
  file.write("</PointData>\n<Points>\n");
  write_array(file, "Points", 3, 3 * sites,
              [&](Eigen::Index i) { return coordinate<Scalar>(samples, i / 3, i % 3); });
  file.write("</Points>\n<Verts>\n");
  write_array(file, "connectivity", 1, sites, [](Eigen::Index i) { return std::int64_t{i}; });
  write_array(file, "offsets", 1, sites, [](Eigen::Index i) { return std::int64_t{i} + 1; });
  file.write("</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n");
  file.commit();
}

/// The legacy format: numbers are big endian.
template <class Scalar>
void write_vtk(const std::filesystem::path& path, const VolumeSamples& samples) {
  const Eigen::Index sites = samples.sites.cols();
  const std::string count = std::to_string(sites);
  const std::string real = sizeof(Scalar) == 4 ? "float" : "double";
  std::string bytes =
      "# vtk DataFile Version 3.0\nccvt samples\nBINARY\nDATASET POLYDATA\nPOINTS " + count + " " +
      real + "\n";
  for (Eigen::Index s = 0; s < sites; ++s) {
    for (Eigen::Index d = 0; d < 3; ++d) append_big(bytes, coordinate<Scalar>(samples, s, d));
  }
  bytes += "\nVERTICES " + count + " " + std::to_string(2 * sites) + "\n";
  for (Eigen::Index s = 0; s < sites; ++s) {
    append_big(bytes, std::int32_t{1});
    append_big(bytes, static_cast<std::int32_t>(s));
  }
  bytes += "\nPOINT_DATA " + count + "\n";
  const auto scalars = [&](const std::string& name, const std::string& type, const auto& values,
                           auto number) {
    bytes += "SCALARS " + name + " " + type + " 1\nLOOKUP_TABLE default\n";
    for (const auto value : values) append_big(bytes, static_cast<decltype(number)>(value));
    bytes += "\n";
  };
  scalars("radius", real, samples.radii, Scalar{});
  scalars("capacity", "int", samples.capacities, std::int32_t{});
  scalars("weight", real, samples.weights, Scalar{});
  io::OutputFile file(path);
  file.write(bytes);
  file.commit();
}

template <class Scalar>
void write_text_samples(const std::filesystem::path& path, char separator,
                        const VolumeSamples& samples) {
  const Eigen::Index dimension = samples.sites.rows();
  std::string text;
  for (Eigen::Index d = 0; d < dimension; ++d) {
    text += dimension <= 3 ? std::string(1, "xyz"[d]) : "x" + std::to_string(d);
    text += separator;
  }
  text += std::string("radius") + separator + "capacity" + separator + "weight\n";
  io::OutputFile file(path);
  for (Eigen::Index s = 0; s < samples.sites.cols(); ++s) {
    const auto i = static_cast<std::size_t>(s);
    for (Eigen::Index d = 0; d < dimension; ++d) {
      io::append(text, static_cast<Scalar>(samples.sites(d, s)));
      text += separator;
    }
    io::append(text, static_cast<Scalar>(samples.radii[i]));
    text += separator;
    io::append(text, samples.capacities[i]);
    text += separator;
    io::append(text, static_cast<Scalar>(samples.weights[i]));
    text += '\n';
    if (text.size() >= kBlock) {
      file.write(text);
      text.clear();
    }
  }
  file.write(text);
  file.commit();
}

template <class Scalar>
void write_as(const std::filesystem::path& path, const VolumeSamples& samples) {
  const std::string extension = io::extension_of(path);
  if (extension == ".csv") return write_text_samples<Scalar>(path, ',', samples);
  if (extension == ".txt") return write_text_samples<Scalar>(path, ' ', samples);
  if (extension == ".ply") return write_ply<Scalar>(path, samples);
  if (extension == ".vtp") return write_vtp<Scalar>(path, samples);
  if (extension == ".vtk") return write_vtk<Scalar>(path, samples);
  throw InvalidInput(path.string() + ": unknown extension " + io::quoted(extension) +
                     "; samples go into " + io::list_of(io::kSampleFiles, " or "));
}

}  // namespace

void write_samples(const std::filesystem::path& path, const VolumeSamples& samples) {
  const std::string extension = io::extension_of(path);
  const auto sites = static_cast<std::size_t>(samples.sites.cols());
  if (samples.radii.size() != sites || samples.capacities.size() != sites ||
      samples.weights.size() != sites) {
    throw InvalidInput("samples: " + std::to_string(sites) + " sites have " +
                       std::to_string(samples.radii.size()) + " radii, " +
                       std::to_string(samples.capacities.size()) + " capacities and " +
                       std::to_string(samples.weights.size()) + " weights; needs one of each");
  }
  if (extension == ".npy") return write_points(path, samples.sites);
  const bool text = extension == ".csv" || extension == ".txt";
  if (!text && samples.sites.rows() > 3) {
    throw InvalidInput(path.string() + ": samples of " + std::to_string(samples.sites.rows()) +
                       " dimensions go into .csv, .txt or .npy");
  }
  const bool wide = samples.scalar == ScalarType::float64 || needs_double(samples);
  wide ? write_as<double>(path, samples) : write_as<float>(path, samples);
}

}  // namespace ccvt
