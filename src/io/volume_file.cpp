#include "io/volume_file.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "ccvt/volume.h"
#include "io/formats.h"
#include "io/npy.h"
#include "number_text.h"

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
                     "; volumes are " + io::list_of(io::kVolumeFiles, " or "));
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
    std::copy(given.begin(), given.end(), result.begin());
    return result;
  };
  const Eigen::Vector3d spacing = vector(layout.spacing, "spacing", 1);
  grid.origin = vector(layout.origin, "origin", 0);
  grid.axes = Eigen::Matrix3d::Zero();
  for (Eigen::Index a = 0; a < 3; ++a) {
    const Eigen::Index d = position.data()[a];
    if (!(spacing[d] > 0)) {
      throw InvalidInput("spacing: entry " + std::to_string(d) + " is " + text(spacing[d]) +
                         "; must be positive");
    }
    grid.axes(d, a) = spacing[d];
  }
}

/// The type that holds what an .npy file stores.
VoxelType voxel_type(io::NpyType type) {
  switch (type) {
    case io::NpyType::int8:
      return VoxelType::int8;
    case io::NpyType::boolean:
    case io::NpyType::uint8:
      return VoxelType::uint8;
    case io::NpyType::int16:
      return VoxelType::int16;
    case io::NpyType::uint16:
      return VoxelType::uint16;
    case io::NpyType::int32:
      return VoxelType::int32;
    case io::NpyType::uint32:
      return VoxelType::uint32;
    case io::NpyType::int64:
      return VoxelType::int64;
    case io::NpyType::uint64:
      return VoxelType::uint64;
    case io::NpyType::float16:
    case io::NpyType::float32:
      return VoxelType::float32;
    case io::NpyType::float64:
      break;
  }
  return VoxelType::float64;
}

VolumeFile open_npy(const std::filesystem::path& path, const VolumeLayout& layout) {
  InputFile file(path);
  const io::NpyHeader npy = io::read_npy_header(file);
  const auto item = io::parse_npy_descr(npy.descr);
  if (!item) {
    file.fail("has dtype " + io::quoted(npy.descr) +
              "; bool, whole numbers of 8 to 64 bits and floats of 16 to 64 can be read");
  }
  const std::string shape = "has the shape " + io::shape_text(npy.shape);
  if (npy.shape.size() != 3) file.fail(shape + "; a volume needs 3 extents");
  io::check_npy_size(file, npy, item->bytes);
  if (std::find(npy.shape.begin(), npy.shape.end(), 0U) != npy.shape.end()) {
    file.fail(shape + ": no cells");
  }
  VolumeFile result;
  result.header.type = voxel_type(item->type);
  if (item->type == io::NpyType::boolean) result.packing = io::Packing::boolean;
  if (item->type == io::NpyType::float16) result.packing = io::Packing::float16;
  result.big_endian = item->big_endian;
  auto& cells = result.header.grid.shape;  // the axis along which memory runs first
  cells.assign(npy.shape.begin(), npy.shape.end());
  if (npy.fortran_order) {
    place(path, layout, {0, 1, 2}, result.header.grid);
  } else {
    std::reverse(cells.begin(), cells.end());
    place(path, layout, {2, 1, 0}, result.header.grid);
  }
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

VolumeFile open_format(Format format, const std::filesystem::path& path,
                       const VolumeLayout& layout) {
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

VolumeFile open_volume(const std::filesystem::path& path, const VolumeLayout& layout) {
  const Format format = format_of(path);
  if (format != Format::raw && (!layout.shape.empty() || layout.type || layout.big_endian)) {
    throw InvalidInput(path.string() + ": says its shape and type itself; do not give them");
  }
  const bool placed = format == Format::nifti || format == Format::nrrd;
  if (placed && (!layout.spacing.empty() || !layout.origin.empty())) {
    throw InvalidInput(path.string() + ": says its spacing and origin itself; do not give them");
  }
  VolumeFile result = open_format(format, path, layout);
  result.header.data_file = result.data;
  return result;
}

/// Writes the float32 of each float16 in `halves`, which may be the last half of `floats`.
void widen_halves(std::span<const std::byte> halves, std::byte* floats) {
  for (std::size_t i = 0; 2 * i < halves.size(); ++i) {
    std::uint16_t half = 0;
    std::memcpy(&half, halves.data() + 2 * i, sizeof half);
    const float value = io::float_of_half(half);
    std::memcpy(floats + 4 * i, &value, sizeof value);
  }
}

/// Layers run along the last axis that has more than one cell.
std::size_t layer_axis(const Grid& grid) {
  std::size_t axis = grid.shape.size() - 1;
  while (axis > 0 && grid.shape[axis] == 1) --axis;
  return axis;
}

/// Goes to the values of a volume; throws InvalidInput unless there is room for all of them.
void go_to_values(const VolumeFile& opened, std::uint64_t bytes, io::ByteStream& stream) {
  const std::uint64_t most = stream.most_left();
  const std::uint64_t skip = opened.at_end && bytes <= most ? most - bytes : opened.skip;
  if (bytes > most || skip > most - bytes) {
    stream.file().fail("is truncated: " + std::to_string(bytes) +
                       " bytes of values are promised, but it " +
                       (opened.gzip ? "cannot hold more than " : "has ") +
                       std::to_string(most > skip ? most - skip : 0));
  }
  stream.skip(skip);
}

Volume read_layers(const VolumeFile& opened, const LayerRange& layers) {
  InputFile file(opened.data);
  if (file.size() < opened.begin) file.fail("is truncated");
  file.skip(opened.begin);
  io::ByteStream stream(file, file.size() - opened.begin, opened.gzip);

  Volume volume;
  static_cast<VolumeHeader&>(volume) = opened.header;
  const std::size_t stored = opened.packing == io::Packing::float16 ? 2 : bytes_of(volume.type);
  go_to_values(opened, volume.cells() * stored, stream);
  Grid& grid = volume.grid;
  const std::size_t axis = layer_axis(grid);
  const std::int64_t count = grid.shape[axis];
  const std::uint64_t layer = volume.cells() / static_cast<std::uint64_t>(count) * stored;
  grid.shape[axis] = layers.end - layers.begin;
  grid.origin.eigen() +=
      static_cast<double>(layers.begin) * grid.axes.eigen().col(static_cast<Eigen::Index>(axis));

  stream.skip(static_cast<std::uint64_t>(layers.begin) * layer);
  volume.data.resize(volume.bytes());
  // At the end of the memory, so that what is narrower can be widened from the front on.
  const std::span<std::byte> data = std::span(volume.data).last(volume.cells() * stored);
  stream.read(data.data(), data.size());
  if (layers.end == count) stream.expect_end();
  if (opened.big_endian && stored > 1) io::swap_bytes(data, stored);
  if (opened.packing == io::Packing::boolean) {
    for (std::byte& value : data) value = value == std::byte{0} ? std::byte{0} : std::byte{1};
  }
  if (opened.packing == io::Packing::float16) widen_halves(data, volume.data.data());
  return volume;
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
    if (__builtin_mul_overflow(bytes, extent, &bytes) ||
        bytes > std::numeric_limits<std::int64_t>::max()) {
      file.fail("claims more cells than any file can hold");
    }
  }
  if (!std::isfinite(header.slope) || header.slope == 0 || !std::isfinite(header.intercept)) {
    file.fail("scales its values by " + text(header.slope) + " and " + text(header.intercept) +
              "; must be finite");
  }
  const Eigen::VectorXd origin = header.grid.origin.eigen();
  const std::string place =
      concat(std::span(origin.data(), static_cast<std::size_t>(origin.size())));
  if (!origin.allFinite()) file.fail("has its origin at " + place + "; must be finite");
  const double volume = header.grid.axes.eigen().determinant();
  if (!std::isfinite(volume) || volume == 0) {
    file.fail(concat("has axes that are not finite, or flat: the volume of a cell is ", volume));
  }
  for (Eigen::Index d = 0; d < std::ssize(header.grid.shape); ++d) {
    const auto extent = static_cast<double>(header.grid.shape[static_cast<std::size_t>(d)]);
    const Eigen::VectorXd cell = header.grid.axes.eigen().col(d);
    const Eigen::VectorXd end = origin + extent * cell;
    if (origin + cell != origin && end - cell != end) continue;
    file.fail(concat("has its origin at ", place, ", too far away to tell its cells along axis ", d,
                     " apart"));
  }
}

void swap_bytes(std::span<std::byte> data, std::size_t item_bytes) {
  for (std::size_t i = 0; i + item_bytes <= data.size(); i += item_bytes) {
    std::reverse(data.data() + i, data.data() + i + item_bytes);
  }
}

}  // namespace io

VolumeHeader inspect_volume(const std::filesystem::path& path, const VolumeLayout& layout) {
  return open_volume(path, layout).header;
}

Volume read_volume(const std::filesystem::path& path, const VolumeLayout& layout) {
  const VolumeFile opened = open_volume(path, layout);
  return read_layers(opened, {0, opened.header.grid.shape[layer_axis(opened.header.grid)]});
}

Volume read_volume(const std::filesystem::path& path, const VolumeLayout& layout,
                   const LayerRange& layers) {
  const VolumeFile opened = open_volume(path, layout);
  const std::int64_t count = opened.header.grid.shape[layer_axis(opened.header.grid)];
  if (layers.begin < 0 || layers.begin > layers.end || layers.end > count) {
    throw InvalidInput("layers: " + std::to_string(layers.begin) + " to " +
                       std::to_string(layers.end) + " are asked for, of " + std::to_string(count) +
                       " in " + path.string() +
                       ": it must hold that 0 <= begin <= end <= " + std::to_string(count));
  }
  return read_layers(opened, layers);
}

}  // namespace ccvt
