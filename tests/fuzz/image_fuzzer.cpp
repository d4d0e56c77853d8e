// Feeds the readers of pictures whatever libFuzzer thinks of. Built with CCVT_FUZZ; see README.md.

#include <zlib.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

#include "ccvt/io.h"
#include "support/files.h"
#include "support/png.h"

namespace {

/// Gives every chunk of a PNG the checksum it should have, which no mutation finds.
void mend_checksums(std::string& bytes) {
  const auto at_byte = [&](std::size_t at) { return static_cast<unsigned char>(bytes[at]); };
  if (bytes.size() < 8 || at_byte(0) != 0x89) return;
  for (std::size_t at = 8; bytes.size() - at >= 12;) {
    const std::size_t length = std::size_t{at_byte(at)} << 24U |
                               std::size_t{at_byte(at + 1)} << 16U |
                               std::size_t{at_byte(at + 2)} << 8U | at_byte(at + 3);
    if (length > bytes.size() - at - 12) return;
    const auto* const checked = reinterpret_cast<const Bytef*>(bytes.data()) + at + 4;
    const auto sum = static_cast<std::uint32_t>(crc32(0, checked, static_cast<uInt>(length + 4)));
    bytes.replace(at + 8 + length, 4, ccvt::test::big_endian(sum));
    at += 12 + length;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const ccvt::test::TemporaryDirectory directory;
  static const std::filesystem::path path = directory / "picture";
  std::string bytes(reinterpret_cast<const char*>(data), size);
  mend_checksums(bytes);
  ccvt::test::put(path, bytes);
  try {
    const ccvt::Image image = ccvt::read_image(path);
    const auto pixels =
        static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    if (image.width < 1 || image.height < 1 || image.values.size() != pixels) __builtin_trap();
    for (const float value : image.values) {
      if (!(value >= 0 && value <= 1)) __builtin_trap();
    }
    if (ccvt::read_colour_image(path).rgb.size() != 3 * pixels) __builtin_trap();
  } catch (const ccvt::InvalidInput&) {
    // One clear line is what a hostile file should get.
  }
  return 0;
}
