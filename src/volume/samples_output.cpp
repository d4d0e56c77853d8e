#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <span>
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

/// What of the samples is written as real numbers, in the type of the file.
template <class Scalar>
struct Reals {
  /// With 0 for the coordinates from the sites' own dimension up to `rows`.
  Reals(const VolumeSamples& samples, std::ptrdiff_t rows)
      : sites(Points<Scalar>::Zero(rows, samples.sites.cols())),
        radii(samples.radii.begin(), samples.radii.end()),
        weights(samples.weights.begin(), samples.weights.end()) {
    sites.topRows(samples.sites.rows()) = samples.sites.eigen().template cast<Scalar>();
  }

  /// The coordinates of a site.
  [[nodiscard]] std::span<const Scalar> site(std::size_t s) const {
    const std::size_t rows = coordinates().size() / radii.size();
    return coordinates().subspan(s * rows, rows);
  }
  /// Those of all sites, one site behind the other.
  [[nodiscard]] std::span<const Scalar> coordinates() const {
    return {sites.data(), sites.data() + sites.size()};
  }

  Points<Scalar> sites;
  std::vector<Scalar> radii;
  std::vector<Scalar> weights;
};

/// Whether float32 moves a site by more than a thousandth of the mean radius, or of the extent of
/// all by what could take it across a face between a cell of density 0 and its own.
bool needs_double(const VolumeSamples& samples) {
  const auto sites = samples.sites.eigen();
  double radius = 0;
  const double count = view_points(samples.sites).count;
  for (const double r : samples.radii) radius += r / count;
  const double extent = (sites.rowwise().maxCoeff() - sites.rowwise().minCoeff()).maxCoeff();
  const double most = std::min(1e-3 * radius, 0x1p-22 * extent);
  return ((sites - sites.cast<float>().cast<double>()).array().abs() > most).any();
}

template <class Scalar>
void write_ply(const std::filesystem::path& path, const VolumeSamples& samples) {
  const std::string real = sizeof(Scalar) == 4 ? "property float " : "property double ";
  std::string bytes = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                      std::to_string(samples.sites.cols()) + "\n" + real + "x\n" + real + "y\n" +
                      real + "z\n" + real + "radius\nproperty int capacity\n" + real +
                      "weight\nend_header\n";
  io::OutputFile file(path);
  const Reals<Scalar> reals(samples, 3);
  for (std::size_t s = 0; s < samples.capacities.size(); ++s) {
    for (const Scalar x : reals.site(s)) append_little(bytes, x);
    append_little(bytes, reals.radii[s]);
    append_little(bytes, samples.capacities[s]);
    append_little(bytes, reals.weights[s]);
    if (bytes.size() >= kBlock) {
      file.write(bytes);
      bytes.clear();
    }
  }
  file.write(bytes);
  file.commit();
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
void write_array(io::OutputFile& file, const char* name, int components,
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
void write_vtp(const std::filesystem::path& path, const VolumeSamples& samples) {
  const Reals<Scalar> reals(samples, 3);
  const std::string count = std::to_string(samples.capacities.size());
  io::OutputFile file(path);
  file.write(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n<Piece NumberOfPoints=\"" +
      count + "\" NumberOfVerts=\"" + count +
      "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
      "<PointData Scalars=\"radius\">\n");
  write_array<Scalar>(file, "radius", 1, reals.radii);
  write_array<Index>(file, "capacity", 1, samples.capacities);
  write_array<Scalar>(file, "weight", 1, reals.weights);
  file.write("</PointData>\n<Points>\n");
  write_array(file, "Points", 3, reals.coordinates());
  file.write("</Points>\n<Verts>\n");
  std::vector<std::int64_t> numbers(samples.capacities.size());
  std::iota(numbers.begin(), numbers.end(), 0);
  write_array<std::int64_t>(file, "connectivity", 1, numbers);
  std::iota(numbers.begin(), numbers.end(), 1);
  write_array<std::int64_t>(file, "offsets", 1, numbers);
  file.write("</Verts>\n</Piece>\n</PolyData>\n</VTKFile>\n");
  file.commit();
}

/// The legacy format: numbers are big endian.
template <class Scalar>
void write_vtk(const std::filesystem::path& path, const VolumeSamples& samples) {
  const Reals<Scalar> reals(samples, 3);
  const Index sites = view_points(samples.sites).count;
  const std::string count = std::to_string(sites);
  const std::string real = sizeof(Scalar) == 4 ? "float" : "double";
  std::string bytes =
      "# vtk DataFile Version 3.0\nccvt samples\nBINARY\nDATASET POLYDATA\nPOINTS " + count + " " +
      real + "\n";
  for (const Scalar x : reals.coordinates()) append_big(bytes, x);
  bytes += "\nVERTICES " + count + " " + std::to_string(2 * samples.sites.cols()) + "\n";
  for (Index s = 0; s < sites; ++s) {
    append_big(bytes, std::int32_t{1});
    append_big(bytes, s);
  }
  bytes += "\nPOINT_DATA " + count + "\n";
  const auto scalars = [&](const std::string& name, const std::string& type, const auto& values) {
    bytes += "SCALARS " + name + " " + type + " 1\nLOOKUP_TABLE default\n";
    for (const auto value : values) append_big(bytes, value);
    bytes += "\n";
  };
  scalars("radius", real, reals.radii);
  scalars("capacity", "int", samples.capacities);
  scalars("weight", real, reals.weights);
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
  const Reals<Scalar> reals(samples, dimension);
  for (std::size_t s = 0; s < samples.capacities.size(); ++s) {
    for (const Scalar x : reals.site(s)) {
      io::append(text, x);
      text += separator;
    }
    io::append(text, reals.radii[s]);
    text += separator;
    io::append(text, samples.capacities[s]);
    text += separator;
    io::append(text, reals.weights[s]);
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
  const std::ptrdiff_t sites = samples.sites.cols();
  if (std::ssize(samples.radii) != sites || std::ssize(samples.capacities) != sites ||
      std::ssize(samples.weights) != sites) {
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
