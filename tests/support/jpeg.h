#pragma once

#include <cstddef>
#include <string>

/// Parts of JPEGs, from which whole and broken ones are made. All tables have one code, a zero bit,
/// and all blocks are even grey (128): two bits each in sequential scans, one in a progressive
/// picture's first.
namespace ccvt::test {

inline std::string jpeg_word(std::size_t value) {
  return {static_cast<char>(value >> 8U), static_cast<char>(value & 0xFFU)};
}

inline std::string jpeg_segment(unsigned marker, const std::string& data) {
  return std::string{'\xFF', static_cast<char>(marker)} + jpeg_word(data.size() + 2) + data;
}

inline std::string jpeg_quantization() {
  return jpeg_segment(0xDB, std::string(1, '\0') + std::string(64, '\1'));
}

/// `counts` of codes of 1 to 16 bits, all for the symbol 0.
inline std::string jpeg_huffman(unsigned kind, const std::string& counts) {
  std::size_t codes = 0;
  for (const char count : counts) codes += static_cast<unsigned char>(count);
  return jpeg_segment(0xC4, static_cast<char>(kind << 4U) + counts + std::string(codes, '\0'));
}

inline std::string jpeg_codes() {
  const std::string one = '\1' + std::string(15, '\0');
  return jpeg_huffman(0, one) + jpeg_huffman(1, one);
}

inline std::string jpeg_tables() { return jpeg_quantization() + jpeg_codes(); }

/// The header of a frame; process 0: baseline, 2: progressive, and so on.
inline std::string jpeg_frame(unsigned process, std::size_t width, std::size_t height,
                              int components = 1, int precision = 8) {
  std::string data = static_cast<char>(precision) + jpeg_word(height) + jpeg_word(width) +
                     static_cast<char>(components);
  for (int c = 1; c <= components; ++c) data += {static_cast<char>(c), '\x11', '\0'};
  return jpeg_segment(0xC0 + process, data);
}

/// A scan of `count` components from `first` with `bits` zero bits, of the coefficients up to
/// `last`.
inline std::string jpeg_scan(int first, int count, std::size_t bits, int last = 63) {
  std::string data(1, static_cast<char>(count));
  for (int c = first; c < first + count; ++c) data += {static_cast<char>(c), '\0'};
  data += {'\0', static_cast<char>(last), '\0'};
  std::string zeros(bits / 8, '\0');
  if (bits % 8 != 0) zeros += static_cast<char>(0xFFU >> (bits % 8));  // padded with ones
  return jpeg_segment(0xDA, data) + zeros;
}

inline std::string make_jpeg(const std::string& segments) {
  return "\xFF\xD8" + segments + "\xFF\xD9";
}

}  // namespace ccvt::test
