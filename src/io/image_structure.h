#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace ccvt::io {

/// What the structure of an image file says, found without decoding it.
struct ImageStructure {
  std::uint64_t width = 0;
  std::uint64_t height = 0;
  std::string error;  ///< what is wrong with the file; empty when it is whole
};

/// Walks the chunks of a PNG (lengths and checksums, to the end of the image) or the segments of a
/// JPEG (lengths, to the end marker). The decoder itself fills what is missing from a truncated
/// JPEG with grey, and does not look at checksums.
ImageStructure inspect_image(std::span<const unsigned char> bytes);

}  // namespace ccvt::io
