#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

/// The only door to stb_image and stb_image_write.
namespace ccvt::io {

/// A decoded picture: rows from the top, channels (1 grey, 2 grey and alpha, 3 colour, 4 colour
/// and alpha) interleaved, one of the two buffers set.
struct Pixels {
  struct Free {
    void operator()(void* memory) const;
  };
  int width = 0;
  int height = 0;
  int channels = 0;
  std::unique_ptr<std::uint8_t[], Free> bits8;
  std::unique_ptr<std::uint16_t[], Free> bits16;
};

/// Decodes PNG or JPEG; without pixels when it cannot, and then `error` says why.
Pixels decode_image(std::span<const unsigned char> bytes, std::string& error);

/// Encodes 8 bits a channel (1: grey, 3: colour, interleaved) as PNG and hands the bytes to
/// `write`, which must not throw. False when out of memory.
bool encode_png(int width, int height, int channels, const std::uint8_t* samples,
                const std::function<void(const void*, std::size_t)>& write);

}  // namespace ccvt::io
