#include "io/volume_file.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "ccvt/volume.h"
#include "format.h"
#include "io/npy.h"

namespace ccvt {

namespace {

using io::InputFile;
using io::VolumeFile;

enum class Format { nifti, nrrd, npy, raw };

Format format_of(const std::filesystem::path& path) {
  const std::string extension = io::extension_of(path);
  const bool packed_nifti = extension == ".gz" && io::extension_of(path.stem()) == ".nii";
  if (extension == ".nii" || packed_nifti) return Format::nifti;
  if (extension == ".nrrd" || extension == ".nhdr") return Format::nrrd;
  if (extension == ".npy") return Format::npy;
  if (extension == ".raw") return Format::raw;
  throw InvalidInput(path.string() + ": unknown extension " + io::quoted(extension) +
                     "; volumes are .nii, .nii.gz, .nrrd, .nhdr, .npy or .raw");
}

/// World coordinates in the order of `position`: axis a of the grid is axis position[a] there.
void place(const std::filesystem::path& path, const VolumeLayout& layout,
           std::array<Eigen::Index, 3> position, Grid& grid) {
  const auto vector = [&](const std::vector<double>& given, const char* name, double other) {
    if (!given.empty() && given.size() != 3) {
      throw InvalidInput(std::string(name) + ": has " + std::to_string(given.size()) +
                         " numbers for " + path.string() + "; needs 3");
    }
    Eigen::Vector3d result = Eigen::Vector3d::Constant(other);
    for (std::size_t d = 0; d < given.size(); ++d) result[static_cast<Eigen::Index>(d)] = given[d];
    return result;
  };
  const Eigen::Vector3d spacing = vector(layout.spacing, "spacing", 1);
  grid.origin = vector(layout.origin, "origin", 0);
  grid.axes = Eigen::Matrix3d::Zero();
  for (Eigen::Index a = 0; a < 3; ++a) {
    const Eigen::Index d = position[static_cast<std::size_t>(a)];
    if (!(spacing[d] > 0)) {
      throw InvalidInput("spacing: entry " + std::to_string(d) + " is " + text(spacing[d]) +
                         "; must be positive");
    }
    grid.axes(d, a) = spacing[d];
  }
}

VolumeFile open_npy(const std::filesystem::path& path, const VolumeLayout& layout) {
  struct Descr {
    const char* code;
    VoxelType type;
  };
  constexpr std::array<Descr, 10> descrs = {{{"i1", VoxelType::int8},
                                             {"u1", VoxelType::uint8},
                                             {"i2", VoxelType::int16},
                                             {"u2", VoxelType::uint16},
                                             {"i4", VoxelType::int32},
                                             {"u4", VoxelType::uint32},
                                             {"i8", VoxelType::int64},
                                             {"u8", VoxelType::uint64},
                                             {"f4", VoxelType::float32},
                                             {"f8", VoxelType::float64}}};
  InputFile file(path);
  const io::NpyHeader npy = io::read_npy_header(file);
  VolumeFile result;
  const auto* const found = std::find_if(descrs.begin(), descrs.end(), [&](const Descr& d) {
    return npy.descr.size() == 3 && npy.descr.substr(1) == d.code &&
           std::string("<>|=").find(npy.descr[0]) != std::string::npos;
  });
  if (found == descrs.end()) {
    file.fail("has dtype " + io::quoted(npy.descr) +
              "; whole numbers and floats of 8 to 64 bits can be read");
  }
  result.header.type = found->type;
  result.big_endian = npy.descr[0] == '>';
  if (npy.shape.size() != 3) {
    file.fail("has the shape " + io::shape_text(npy.shape) + "; a volume needs 3 extents");
  }
  io::check_npy_size(file, npy, bytes_of(found->type));
  for (std::size_t d = 3; d-- > 0;) {  // the last one varies fastest
    result.header.grid.shape.push_back(static_cast<std::int64_t>(npy.shape[d]));
  }
  place(path, layout, {2, 1, 0}, result.header.grid);
  result.data = path;
  result.begin = file.size() - npy.data_bytes;
  io::check_volume(file, result.header);
  return result;
}

VolumeFile open_raw(const std::filesystem::path& path, const VolumeLayout& layout) {
  if (layout.shape.size() != 3 || !layout.type) {
    throw InvalidInput(path.string() + ": is a raw file; needs a shape of 3 numbers and a type");
  }
  const InputFile file(path);
  VolumeFile result;
  result.header.type = *layout.type;
  result.header.grid.shape = layout.shape;
  result.big_endian = layout.big_endian;
  place(path, layout, {0, 1, 2}, result.header.grid);
  result.data = path;
  io::check_volume(file, result.header);
  return result;
}

VolumeFile open_volume(const std::filesystem::path& path, const VolumeLayout& layout) {
  const Format format = format_of(path);
  if (format != Format::raw && (!layout.shape.empty() || layout.type || layout.big_endian)) {
    throw InvalidInput(path.string() + ": says its shape and type itself; do not give them");
  }
  const bool placed = format == Format::nifti || format == Format::nrrd;
  if (placed && (!layout.spacing.empty() || !layout.origin.empty())) {
    throw InvalidInput(path.string() + ": says its spacing and origin itself; do not give them");
  }
  switch (format) {
    case Format::nifti:
      return io::open_nifti(path);
    case Format::nrrd:
      return io::open_nrrd(path);
    case Format::npy:
      return open_npy(path, layout);
    case Format::raw:
      break;
  }
  return open_raw(path, layout);
}

}  // namespace

namespace io {

void check_volume(const InputFile& file, const VolumeHeader& header) {
  std::uint64_t bytes = bytes_of(header.type);
  for (std::size_t d = 0; d < header.grid.shape.size(); ++d) {
    const std::int64_t extent = header.grid.shape[d];
    if (extent < 1) {
      file.fail("has " + std::to_string(extent) + " cells along axis " + std::to_string(d) +
                "; needs at least 1");
    }
    if (__builtin_mul_overflow(bytes, static_cast<std::uint64_t>(extent), &bytes) ||
        bytes > static_cast<std::uint64_t>(std::numeric_limits<std::int64_t>::max())) {
      file.fail("claims more cells than any file can hold");
    }
  }
  if (!std::isfinite(header.slope) || header.slope == 0 || !std::isfinite(header.intercept)) {
    file.fail("scales its values by " + text(header.slope) + " and " + text(header.intercept) +
              "; must be finite");
  }
  const double volume = header.grid.axes.determinant();
  if (!header.grid.origin.allFinite() || !std::isfinite(volume) || volume == 0) {
    file.fail("places its cells by axes and an origin that are not finite, or flat");
  }
}

void swap_bytes(std::span<std::byte> data, std::size_t item_bytes) {
  for (std::size_t i = 0; i + item_bytes <= data.size(); i += item_bytes) {
    std::reverse(data.begin() + static_cast<std::ptrdiff_t>(i),
                 data.begin() + static_cast<std::ptrdiff_t>(i + item_bytes));
  }
}

}  // namespace io

VolumeHeader inspect_volume(const std::filesystem::path& path, const VolumeLayout& layout) {
  return open_volume(path, layout).header;
}

Volume read_volume(const std::filesystem::path& path, const VolumeLayout& layout) {
  VolumeFile opened = open_volume(path, layout);
  InputFile file(opened.data);
  if (file.size() < opened.begin) file.fail("is truncated");
  file.skip(opened.begin);
  io::ByteStream stream(file, file.size() - opened.begin, opened.gzip);

  Volume volume;
  static_cast<VolumeHeader&>(volume) = std::move(opened.header);
  const std::uint64_t bytes = volume.bytes();
  const std::uint64_t most = stream.most_left();
  if (opened.at_end && bytes <= most) opened.skip = most - bytes;
  if (bytes > most || opened.skip > most - bytes) {
    file.fail("is truncated: " + std::to_string(bytes) + " bytes of values are promised, but it " +
              (opened.gzip ? "cannot hold more than " : "has ") +
              std::to_string(most > opened.skip ? most - opened.skip : 0));
  }
  stream.skip(opened.skip);
  volume.data.resize(bytes);
  stream.read(volume.data.data(), volume.data.size());
  stream.expect_end();
  const std::size_t item = bytes_of(volume.type);
  if (opened.big_endian && item > 1) io::swap_bytes(volume.data, item);
  return volume;
}

}  // namespace ccvt
