#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "ccvt/volume.h"
#include "io/byte_stream.h"
#include "io/input_file.h"

/// What the readers of volumes share.
namespace ccvt::io {

/// How a file stores values of a type that no volume has.
enum class Packing { none, boolean, float16 };

/// A header, and where its data are.
struct VolumeFile {
  VolumeHeader header;
  Packing packing = Packing::none;  ///< boolean becomes uint8, float16 becomes float32
  bool big_endian = false;
  std::filesystem::path data;  ///< the file that holds the values
  std::uint64_t begin = 0;     ///< where in it the stream of bytes begins
  bool gzip = false;           ///< whether that stream is packed
  std::uint64_t skip = 0;      ///< bytes of the stream in front of the values
  bool at_end = false;         ///< the values are the last bytes of a stream that is not packed
};

/// These read headers, and throw InvalidInput for what they do not allow.
VolumeFile open_nifti(const std::filesystem::path& path);
VolumeFile open_nrrd(const std::filesystem::path& path);

/// Throws InvalidInput unless shape, values and places of the grid are possible.
void check_volume(const InputFile& file, const VolumeHeader& header);

/// Reverses the bytes of each item.
void swap_bytes(std::span<std::byte> data, std::size_t item_bytes);

}  // namespace ccvt::io
