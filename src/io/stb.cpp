#include "io/stb.h"

#include <climits>

// Private copies: nothing of stb is visible outside this file, so that programs may have theirs.
#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_NO_STDIO
#define STBI_NO_LINEAR
#define STBI_NO_HDR
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#ifdef __GNUC__
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_image.h>
#include <stb_image_write.h>
#ifdef __GNUC__
#pragma GCC diagnostic pop
#endif

namespace ccvt::io {

void Pixels::Free::operator()(void* memory) const { stbi_image_free(memory); }

Pixels decode_image(std::span<const unsigned char> bytes, std::string& error) {
  Pixels pixels;
  if (bytes.size() > INT_MAX) {
    error = "is larger than 2 GiB";
    return pixels;
  }
  const auto size = static_cast<int>(bytes.size());
  int* const w = &pixels.width;
  int* const h = &pixels.height;
  int* const c = &pixels.channels;
  if (stbi_is_16_bit_from_memory(bytes.data(), size) != 0) {
    pixels.bits16.reset(stbi_load_16_from_memory(bytes.data(), size, w, h, c, 0));
  } else {
    pixels.bits8.reset(stbi_load_from_memory(bytes.data(), size, w, h, c, 0));
  }
  if (!pixels.bits8 && !pixels.bits16) {
    const char* const reason = stbi_failure_reason();
    error = std::string("cannot be decoded: ") + (reason != nullptr ? reason : "unknown reason");
  }
  return pixels;
}

bool encode_png(int width, int height, int channels, const std::uint8_t* samples,
                const std::function<void(const void*, std::size_t)>& write) {
  const auto forward = [](void* context, void* data, int size) {
    const auto& target =
        *static_cast<const std::function<void(const void*, std::size_t)>*>(context);
    target(data, static_cast<std::size_t>(size));
  };
  auto context = write;
  return stbi_write_png_to_func(forward, &context, width, height, channels, samples,
                                width * channels) != 0;
}

}  // namespace ccvt::io
