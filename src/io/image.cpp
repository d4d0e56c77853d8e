#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "ccvt/io.h"
#include "io/formats.h"
#include "io/input_file.h"
#include "io/output_file.h"
#include "io/picture.h"

namespace ccvt {

namespace io {

void check_size(const InputFile& file, std::uint64_t width, std::uint64_t height,
                std::uint64_t most_in_file) {
  const std::string size_text = std::to_string(width) + " x " + std::to_string(height) + " pixels";
  if (width == 0 || height == 0) file.fail("has " + size_text);
  if (width > kMostPixels / height) {
    file.fail("has " + size_text + "; at most " + std::to_string(kMostPixels) + " are supported");
  }
  if (width * height > most_in_file) {
    file.fail("claims " + size_text + ", more than its " + std::to_string(file.size()) +
              " bytes can hold");
  }
}

}  // namespace io

namespace {

template <int Depth>
std::uint64_t sample(const std::uint8_t* row, std::size_t index) {
  if constexpr (Depth == 8) return row[index];
  return std::uint64_t{256} * row[2 * index] + row[2 * index + 1];
}

/// Grey on white. In whole numbers, so that white becomes 1 exactly.
template <int Depth>
void to_grey(const io::PictureLayout& layout, const std::uint8_t* row, float* values) {
  constexpr std::uint64_t weights[3] = {2126, 7152, 722};  // Rec. 709, sum 10000
  constexpr std::uint64_t full = (1U << Depth) - 1;
  constexpr double white = 10000 * full * full;
  const std::size_t channels = layout.channels;
  const std::size_t size = layout.width * channels;
  const bool colour = channels >= 3;
  const bool alpha = channels % 2 == 0;
  for (std::size_t at = 0; at < size; at += channels) {
    std::uint64_t grey = 0;
    for (std::size_t c = 0; colour && c < 3; ++c) grey += weights[c] * sample<Depth>(row, at + c);
    if (!colour) grey = 10000 * sample<Depth>(row, at);
    const std::uint64_t opaque = alpha ? sample<Depth>(row, at + channels - 1) : full;
    const std::uint64_t composited = grey * opaque + 10000 * full * (full - opaque);
    *values++ = static_cast<float>(static_cast<double>(composited) / white);
  }
}

/// Red, green and blue on white, in 8 bits.
template <int Depth>
void to_colour(const io::PictureLayout& layout, const std::uint8_t* row, std::uint8_t* rgb) {
  constexpr std::uint64_t full = (1U << Depth) - 1;
  const std::size_t channels = layout.channels;
  const std::size_t size = layout.width * channels;
  const bool alpha = channels % 2 == 0;
  for (std::size_t at = 0; at < size; at += channels) {
    const std::uint64_t opaque = alpha ? sample<Depth>(row, at + channels - 1) : full;
    for (std::size_t c = 0; c < 3; ++c) {
      const std::uint64_t composited =
          sample<Depth>(row, at + (channels >= 3 ? c : 0)) * opaque + full * (full - opaque);
      *rgb++ = static_cast<std::uint8_t>((510 * composited + full * full) / (2 * full * full));
    }
  }
}

std::unique_ptr<io::PictureDecoder> open_picture(const io::InputFile& file,
                                                 std::span<const unsigned char> bytes) {
  const auto starts_with = [&](std::initializer_list<unsigned char> magic) {
    return bytes.size() >= magic.size() && std::equal(magic.begin(), magic.end(), bytes.begin());
  };
  if (starts_with({0x89, 'P', 'N', 'G'})) return io::open_png(file, bytes);
  if (starts_with({0xFF, 0xD8, 0xFF})) return io::open_jpeg(file, bytes);
  file.fail("is neither PNG nor JPEG");
}

/// Calls append(layout, row, values) with each row. Memory for rows that do not come is not
/// touched. `values` are those of the image.
template <class AnyImage, class Value, class Append>
void read_rows(const std::filesystem::path& path, std::size_t values_per_pixel, AnyImage& image,
               std::vector<Value>& values, Append append) {
  io::InputFile file(path);
  if (file.size() > (std::uint64_t{1} << 31) - 1) file.fail("is larger than 2 GiB");
  std::vector<unsigned char> bytes(file.size());
  file.read(bytes.data(), bytes.size());
  const auto decoder = open_picture(file, bytes);
  const io::PictureLayout layout = decoder->layout();
  const std::size_t row_size = values_per_pixel * layout.width;
  values.reserve(row_size * layout.height);
  for (std::size_t y = 0; y < layout.height; ++y) {
    const std::uint8_t* const row = decoder->next_row();
    values.resize(values.size() + row_size);
    append(layout, row, values.data() + values.size() - row_size);
  }
  decoder->finish();
  image.width = static_cast<int>(layout.width);
  image.height = static_cast<int>(layout.height);
  if (layout.orientation.upright()) return;
  values = layout.orientation.turned(values, values_per_pixel, image.width, image.height);
}

}  // namespace

Image read_image(const std::filesystem::path& path) {
  Image image;
  read_rows(path, 1, image, image.values, [](const auto& rows, auto row, auto out) {
    rows.depth == 8 ? to_grey<8>(rows, row, out) : to_grey<16>(rows, row, out);
  });
  return image;
}

ColourImage read_colour_image(const std::filesystem::path& path) {
  ColourImage image;
  read_rows(path, 3, image, image.rgb, [](const auto& rows, auto row, auto out) {
    rows.depth == 8 ? to_colour<8>(rows, row, out) : to_colour<16>(rows, row, out);
  });
  return image;
}

namespace {

void write_png(const std::filesystem::path& path, int width, int height, int channels,
               const std::vector<std::uint8_t>& samples) {
  io::OutputFile file(path);
  io::encode_png(file, width, height, channels, samples.data());
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
  if (pixels == 0 || pixels > io::kMostPixels || values != channels * pixels) {
    throw InvalidInput("image: has " + std::to_string(values) + " values for " +
                       std::to_string(width) + " x " + std::to_string(height) +
                       " pixels; from 1 to " + std::to_string(io::kMostPixels) + " pixels with " +
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
