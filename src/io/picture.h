#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "io/input_file.h"
#include "io/orientation.h"

/// The doors to libpng and libjpeg: only the files behind these functions see them. Both leave a
/// call that fails by longjmp(), which stays inside a function that owns nothing.
namespace ccvt::io {

class OutputFile;

inline constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;

/// How a decoded row is laid out: samples interleaved, two bytes of one are big endian.
struct PictureLayout {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t channels = 0;  ///< 1 grey, 2 grey and alpha, 3 colour, 4 colour and alpha
  int depth = 0;             ///< 8 or 16 bits
  Orientation orientation = {};
};

/// A picture that is decoded row by row. Its functions throw InvalidInput, which names the file.
class PictureDecoder {
 public:
  PictureDecoder() = default;
  PictureDecoder(const PictureDecoder&) = delete;
  PictureDecoder& operator=(const PictureDecoder&) = delete;
  virtual ~PictureDecoder() = default;

  [[nodiscard]] virtual PictureLayout layout() const = 0;
  /// The next row from the top, valid until the next call. To be called `height` times.
  virtual const std::uint8_t* next_row() = 0;
  /// After the last row: checks what is left of the file, to the end of the picture.
  virtual void finish() = 0;
};

/// Decoders of `bytes`, the contents of `file`, both to outlive them. They have read the header,
/// and allocate nothing for the pixels unless these fit kMostPixels and check_size().
std::unique_ptr<PictureDecoder> open_png(const InputFile& file,
                                         std::span<const unsigned char> bytes);
std::unique_ptr<PictureDecoder> open_jpeg(const InputFile& file,
                                          std::span<const unsigned char> bytes);

/// Refuses pictures of no pixels, of more than kMostPixels, or of more than `most_in_file`.
void check_size(const InputFile& file, std::uint64_t width, std::uint64_t height,
                std::uint64_t most_in_file);

/// Writes 8 bits a channel (1: grey, 3: colour, interleaved) as PNG. Throws what `file` throws.
void encode_png(OutputFile& file, int width, int height, int channels, const std::uint8_t* samples);

}  // namespace ccvt::io
