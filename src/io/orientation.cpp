#include "io/orientation.h"

#include <algorithm>
#include <cstdint>

namespace ccvt::io {

namespace {

constexpr unsigned char kExif[] = {'E', 'x', 'i', 'f', 0, 0};
constexpr unsigned char kLittleEndian[] = {'I', 'I', 42, 0};
constexpr unsigned char kBigEndian[] = {'M', 'M', 0, 42};
constexpr std::size_t kEntryBytes = 12;
constexpr std::uint32_t kOrientation = 0x0112;
constexpr std::uint32_t kShort = 3;

bool starts_with(std::span<const unsigned char> bytes, std::span<const unsigned char> magic) {
  return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
}

/// The whole number of so many bytes at `at`, which are there.
std::uint32_t number(std::span<const unsigned char> bytes, std::size_t at, std::size_t size,
                     bool big_endian) {
  std::uint32_t result = 0;
  for (std::size_t k = 0; k < size; ++k) {
    result = 256 * result + bytes[at + (big_endian ? k : size - 1 - k)];
  }
  return result;
}

}  // namespace

Orientation::Orientation(std::span<const unsigned char> exif) {
  const std::span<const unsigned char> tiff =
      exif.subspan(starts_with(exif, kExif) ? sizeof kExif : 0);
  const bool big_endian = starts_with(tiff, kBigEndian);
  if (!big_endian && !starts_with(tiff, kLittleEndian)) return;
  const auto get = [&](std::size_t at, std::size_t size) {
    return number(tiff, at, size, big_endian);
  };
  if (tiff.size() < 8) return;
  const std::size_t directory = get(4, 4);
  if (directory + 2 > tiff.size()) return;
  const std::size_t first = directory + 2;
  const std::size_t entries =
      std::min<std::size_t>(get(directory, 2), (tiff.size() - first) / kEntryBytes);
  for (std::size_t e = 0; e < entries; ++e) {
    const std::size_t entry = first + e * kEntryBytes;
    if (get(entry, 2) != kOrientation) continue;
    const std::uint32_t tag = get(entry + 8, 2);
    if (get(entry + 2, 2) == kShort && tag >= 1 && tag <= 8) tag_ = static_cast<int>(tag);
    return;
  }
}

}  // namespace ccvt::io
