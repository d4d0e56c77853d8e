#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace ccvt::test {

inline std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (unsigned shift = 32; shift > 0;) bytes += static_cast<char>((value >> (shift -= 8)) & 0xFFU);
  return bytes;
}

inline std::string png_chunk(const std::string& name, const std::string& data) {
  const std::string checked = name + data;
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const char c : checked) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return big_endian(static_cast<std::uint32_t>(data.size())) + checked + big_endian(~crc);
}

/// A zlib stream of one block that is not compressed: fewer than 65 kB.
inline std::string stored(const std::string& raw) {
  std::uint32_t a = 1;
  std::uint32_t b = 0;
  for (const char c : raw) {
    a = (a + static_cast<unsigned char>(c)) % 65521;
    b = (b + a) % 65521;
  }
  const auto low = static_cast<char>(raw.size() & 0xFFU);
  const auto high = static_cast<char>(raw.size() >> 8U);
  std::string zlib = "\x78\x01\x01";
  zlib += {low, high, static_cast<char>(~low), static_cast<char>(~high)};
  return zlib + raw + big_endian(b << 16U | a);
}

inline std::string png_header(std::uint32_t width, std::uint32_t height, int depth, int colour_type,
                              bool interlaced = false) {
  return png_chunk("IHDR", big_endian(width) + big_endian(height) +
                               std::string{static_cast<char>(depth), static_cast<char>(colour_type),
                                           0, 0, static_cast<char>(interlaced ? 1 : 0)});
}

/// Chunks between the signature and the end.
inline std::string png_of(const std::string& chunks) {
  return "\x89PNG\r\n\x1A\n" + chunks + png_chunk("IEND", "");
}

/// The rows of an image, or of one pass of it, as PNG packs them, filter bytes included.
inline std::string png_rows(std::uint32_t width, std::uint32_t height, int depth, int channels,
                            const std::vector<unsigned>& samples, std::uint32_t left = 0,
                            std::uint32_t top = 0, std::uint32_t step_x = 1,
                            std::uint32_t step_y = 1) {
  std::string raw;
  const auto per_pixel = static_cast<std::uint32_t>(channels);
  for (std::uint32_t y = top; y < height && left < width; y += step_y) {
    raw += '\0';
    unsigned packed = 0;
    int bits = 0;
    for (std::uint32_t x = left; x < width; x += step_x) {
      for (std::uint32_t c = 0; c < per_pixel; ++c) {
        packed =
            (packed << static_cast<unsigned>(depth)) | samples[(y * width + x) * per_pixel + c];
        bits += depth;
        for (; bits >= 8; bits -= 8) raw += static_cast<char>((packed >> (bits - 8)) & 0xFFU);
      }
    }
    if (bits > 0) raw += static_cast<char>((packed << (8 - bits)) & 0xFFU);
  }
  return raw;
}

/// A PNG of any colour type and depth, not compressed; `samples` row by row, channels interleaved.
/// Fewer than 65 kB. `extra` goes between the header and the picture.
inline std::string make_png(std::uint32_t width, std::uint32_t height, int depth, int colour_type,
                            const std::vector<unsigned>& samples, const std::string& extra = "",
                            bool interlaced = false) {
  const auto channels = static_cast<int>(samples.size() / width / height);
  std::string raw;
  if (interlaced) {  // Adam7: left, top, step to the right, step down
    constexpr std::uint32_t passes[7][4] = {{0, 0, 8, 8}, {4, 0, 8, 8}, {0, 4, 4, 8}, {2, 0, 4, 4},
                                            {0, 2, 2, 4}, {1, 0, 2, 2}, {0, 1, 1, 2}};
    for (const auto& [left, top, step_x, step_y] : passes) {
      raw += png_rows(width, height, depth, channels, samples, left, top, step_x, step_y);
    }
  } else {
    raw = png_rows(width, height, depth, channels, samples);
  }
  return png_of(png_header(width, height, depth, colour_type, interlaced) + extra +
                png_chunk("IDAT", stored(raw)));
}

}  // namespace ccvt::test
