#include "io/image_structure.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

namespace ccvt::io {

namespace {

using Bytes = std::span<const unsigned char>;

constexpr std::array<unsigned char, 8> kPngSignature = {0x89, 'P',  'N',  'G',
                                                        0x0D, 0x0A, 0x1A, 0x0A};

std::uint32_t big_endian(Bytes bytes, std::size_t at, std::size_t width) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < width; ++i) value = (value << 8U) | bytes[at + i];
  return value;
}

/// CRC-32 of ISO 3309, as PNG uses it.
std::uint32_t crc32(Bytes bytes) {
  static const auto table = [] {
    std::array<std::uint32_t, 256> result{};
    for (std::uint32_t n = 0; n < 256; ++n) {
      std::uint32_t c = n;
      for (int k = 0; k < 8; ++k) c = (c & 1U) != 0 ? 0xEDB88320U ^ (c >> 1U) : c >> 1U;
      result[n] = c;
    }
    return result;
  }();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const unsigned char byte : bytes) crc = table[(crc ^ byte) & 0xFFU] ^ (crc >> 8U);
  return crc ^ 0xFFFFFFFFU;
}

ImageStructure inspect_png(Bytes bytes) {
  ImageStructure result;
  for (std::size_t at = kPngSignature.size();;) {
    if (bytes.size() - at < 12) {
      result.error = "is a truncated PNG: it ends before its IEND chunk";
      return result;
    }
    const std::uint32_t length = big_endian(bytes, at, 4);
    const std::string_view name(reinterpret_cast<const char*>(bytes.data()) + at + 4, 4);
    if (length > bytes.size() - at - 12) {
      result.error = "is a truncated PNG: a chunk claims more bytes than the file has";
      return result;
    }
    if (crc32(bytes.subspan(at + 4, length + 4U)) != big_endian(bytes, at + 8 + length, 4)) {
      result.error = "is a damaged PNG: the checksum of a chunk is wrong";
      return result;
    }
    if (at == kPngSignature.size()) {
      if (name != "IHDR" || length != 13) {
        result.error = "is a damaged PNG: it has no IHDR chunk";
        return result;
      }
      result.width = big_endian(bytes, at + 8, 4);
      result.height = big_endian(bytes, at + 12, 4);
    }
    if (name == "IEND") return result;
    at += 12 + length;
  }
}

bool is_frame_header(unsigned marker) {
  return marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
}

ImageStructure inspect_jpeg(Bytes bytes) {
  ImageStructure result;
  const char* const truncated = "is a truncated JPEG: it ends before its end marker";
  for (std::size_t at = 2;;) {
    // Skips entropy-coded data, in which a marker is 0xFF and neither zero, fill nor restart.
    const auto is_marker = [&](std::size_t i) {
      return bytes[i] == 0xFF && bytes[i + 1] != 0 && bytes[i + 1] != 0xFF &&
             (bytes[i + 1] < 0xD0 || bytes[i + 1] > 0xD7);
    };
    while (at + 1 < bytes.size() && !is_marker(at)) ++at;
    if (at + 1 >= bytes.size()) {
      result.error = truncated;
      return result;
    }
    const unsigned marker = bytes[at + 1];
    at += 2;
    if (marker == 0xD9) break;
    if (marker == 0x01 || marker == 0xD8) continue;
    if (bytes.size() - at < 2 || big_endian(bytes, at, 2) > bytes.size() - at) {
      result.error = truncated;
      return result;
    }
    const std::uint32_t length = big_endian(bytes, at, 2);
    if (is_frame_header(marker) && length >= 7) {
      result.height = big_endian(bytes, at + 3, 2);
      result.width = big_endian(bytes, at + 5, 2);
    }
    at += std::max<std::size_t>(length, 2);
  }
  if (result.width == 0 || result.height == 0) result.error = "is a JPEG without a picture";
  return result;
}

}  // namespace

ImageStructure inspect_image(Bytes bytes) {
  if (bytes.size() >= kPngSignature.size() &&
      std::equal(kPngSignature.begin(), kPngSignature.end(), bytes.begin())) {
    return inspect_png(bytes);
  }
  if (bytes.size() >= 3 && big_endian(bytes, 0, 3) == 0xFFD8FF) return inspect_jpeg(bytes);
  ImageStructure result;
  result.error = "is neither PNG nor JPEG";
  return result;
}

}  // namespace ccvt::io
