#pragma once

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

/// A PNG of any colour type and depth, not compressed; `samples` row by row, channels interleaved.
/// Fewer than 65 kB. `extra` goes between the header and the picture.
inline std::string make_png(std::uint32_t width, std::uint32_t height, int depth, int colour_type,
                            const std::vector<unsigned>& samples, const std::string& extra = "") {
  std::string raw;
  const std::size_t row = samples.size() / height;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    if (i % row == 0) raw += '\0';
    if (depth == 16) raw += static_cast<char>(samples[i] >> 8U);
    raw += static_cast<char>(samples[i] & 0xFFU);
  }
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
  zlib += raw + big_endian(b << 16U | a);
  std::string header = big_endian(width) + big_endian(height);
  header += {static_cast<char>(depth), static_cast<char>(colour_type), 0, 0, 0};
  return "\x89PNG\r\n\x1A\n" + png_chunk("IHDR", header) + extra + png_chunk("IDAT", zlib) +
         png_chunk("IEND", "");
}

}  // namespace ccvt::test
