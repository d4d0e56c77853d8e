#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "io/image_structure.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "io/stb.h"

namespace ccvt {

namespace {

constexpr std::uint64_t kMostPixels = std::uint64_t{1} << 28;
/// No PNG or JPEG stores more pixels in a byte: a PNG of one bit a pixel reaches 8 * 1032.
constexpr std::uint64_t kMostPixelsPerByte = std::uint64_t{8} * 1032;

/// Grey on white. In whole numbers, so that white becomes 1 exactly.
template <class Sample>
void to_grey(const Sample* samples, std::uint64_t full, int channels, std::vector<float>& values) {
  constexpr std::uint64_t weights[3] = {2126, 7152, 722};  // Rec. 709, sum 10000
  const auto stride = static_cast<std::size_t>(channels);
  const bool colour = channels >= 3;
  const bool alpha = channels == 2 || channels == 4;
  for (float& value : values) {
    std::uint64_t grey = 0;
    for (std::size_t c = 0; colour && c < 3; ++c) grey += weights[c] * samples[c];
    if (!colour) grey = std::uint64_t{10000} * samples[0];
    const std::uint64_t opaque = alpha ? samples[stride - 1] : full;
    const std::uint64_t composited = grey * opaque + 10000 * full * (full - opaque);
    value = static_cast<float>(static_cast<double>(composited) /
                               static_cast<double>(10000 * full * full));
    samples += stride;
  }
}

/// Red, green and blue on white, in 8 bits.
template <class Sample>
void to_colour(const Sample* samples, std::uint64_t full, int channels,
               std::vector<std::uint8_t>& rgb) {
  const auto stride = static_cast<std::size_t>(channels);
  const bool alpha = channels == 2 || channels == 4;
  for (std::size_t k = 0; k < rgb.size(); k += 3, samples += stride) {
    const std::uint64_t opaque = alpha ? samples[stride - 1] : full;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint64_t composited =
          samples[channels >= 3 ? c : 0] * opaque + full * (full - opaque);
      rgb[k + c] = static_cast<std::uint8_t>((510 * composited + full * full) / (2 * full * full));
    }
  }
}

/// Decodes, after all checks.
io::Pixels read_pixels(const std::filesystem::path& path) {
  io::InputFile file(path);
  if (file.size() > (std::uint64_t{1} << 31) - 1) file.fail("is larger than 2 GiB");
  std::vector<unsigned char> bytes(file.size());
  file.read(bytes.data(), bytes.size());
  const io::ImageStructure structure = io::inspect_image(bytes);
  if (!structure.error.empty()) file.fail(structure.error);
  const std::string size_text =
      std::to_string(structure.width) + " x " + std::to_string(structure.height) + " pixels";
  if (structure.width == 0 || structure.height == 0) file.fail("has " + size_text);
  if (structure.width > kMostPixels / structure.height) {
    file.fail("has " + size_text + "; at most " + std::to_string(kMostPixels) + " are supported");
  }
  if (structure.width * structure.height > bytes.size() * kMostPixelsPerByte) {
    file.fail("claims " + size_text + ", more than its " + std::to_string(bytes.size()) +
              " bytes can hold");
  }

  std::string error;
  io::Pixels pixels = io::decode_image(bytes, error);
  if (!error.empty()) file.fail(error);
  return pixels;
}

std::size_t pixel_count(const io::Pixels& pixels) {
  return static_cast<std::size_t>(pixels.width) * static_cast<std::size_t>(pixels.height);
}

}  // namespace

Image read_image(const std::filesystem::path& path) {
  const io::Pixels pixels = read_pixels(path);
  Image image{pixels.width, pixels.height, std::vector<float>(pixel_count(pixels))};
  if (pixels.bits16) {
    to_grey(pixels.bits16.get(), 65535, pixels.channels, image.values);
  } else {
    to_grey(pixels.bits8.get(), 255, pixels.channels, image.values);
  }
  return image;
}

ColourImage read_colour_image(const std::filesystem::path& path) {
  const io::Pixels pixels = read_pixels(path);
  ColourImage image{pixels.width, pixels.height,
                    std::vector<std::uint8_t>(3 * pixel_count(pixels))};
  if (pixels.bits16) {
    to_colour(pixels.bits16.get(), 65535, pixels.channels, image.rgb);
  } else {
    to_colour(pixels.bits8.get(), 255, pixels.channels, image.rgb);
  }
  return image;
}

namespace {

void write_png(const std::filesystem::path& path, int width, int height, int channels,
               const std::vector<std::uint8_t>& samples) {
  std::vector<char> encoded;
  const bool done =
      io::encode_png(width, height, channels, samples.data(), [&](const void* data, std::size_t n) {
        const char* const first = static_cast<const char*>(data);
        encoded.insert(encoded.end(), first, first + n);
      });
  if (!done) throw IoError(path.string() + ": cannot be encoded");
  io::OutputFile file(path);
  file.write(encoded.data(), encoded.size());
  file.commit();
}

void check_png(const std::filesystem::path& path, int width, int height, std::size_t values,
               std::uint64_t channels) {
  if (io::extension_of(path) != ".png") {
    throw InvalidInput(path.string() + ": unknown extension " + io::quoted(io::extension_of(path)) +
                       "; pictures go into .png");
  }
  const auto pixels = width < 1 || height < 1
                          ? std::uint64_t{0}
                          : static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
  if (pixels == 0 || pixels > kMostPixels || values != channels * pixels) {
    throw InvalidInput("image: has " + std::to_string(values) + " values for " +
                       std::to_string(width) + " x " + std::to_string(height) +
                       " pixels; from 1 to " + std::to_string(kMostPixels) + " pixels with " +
                       (channels == 1 ? "one value" : std::to_string(channels) + " values") +
                       " each can be written");
  }
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image) {
  check_png(path, image.width, image.height, image.values.size(), 1);
  std::vector<std::uint8_t> grey(image.values.size());
  std::transform(image.values.begin(), image.values.end(), grey.begin(), [](float value) {
    return value > 0 ? static_cast<std::uint8_t>(std::min(value, 1.0F) * 255.0F + 0.5F)
                     : std::uint8_t{0};
  });
  write_png(path, image.width, image.height, 1, grey);
}

void write_png(const std::filesystem::path& path, const ColourImage& image) {
  check_png(path, image.width, image.height, image.rgb.size(), 3);
  write_png(path, image.width, image.height, 3, image.rgb);
}

}  // namespace ccvt
