// Writes small valid pictures of every kind into the folders png and jpeg of the folder given.
// From them image_fuzzer starts.

#include <png.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <initializer_list>
#include <string>
#include <vector>

#include "support/files.h"

// It needs <cstdio> before it.
#include <jpeglib.h>

namespace {

constexpr unsigned kWidth = 19;
constexpr unsigned kHeight = 13;

/// Something with edges and slopes, that neither filters nor codes find trivial.
std::vector<unsigned char> samples(std::size_t count) {
  std::vector<unsigned char> result(count);
  for (std::size_t i = 0; i < count; ++i) {
    result[i] = static_cast<unsigned char>(i * i / 7 + (i % 40 < 11 ? 90 : 0));
  }
  return result;
}

void append(png_structp png, png_bytep data, std::size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<char*>(data), count);
}

/// libpng's and libjpeg's own handlers of errors end the program, which is what a tool wants.
std::string png_seed(int colour_type, int depth, int interlace, bool transparent) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &bytes, append, nullptr);
  png_set_IHDR(png, info, kWidth, kHeight, depth, colour_type, interlace,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_ALL_FILTERS);
  const png_color palette[] = {{0, 0, 0}, {255, 255, 255}};
  std::vector<png_color> colours(colour_type == PNG_COLOR_TYPE_PALETTE ? 1U << unsigned(depth) : 0);
  for (std::size_t i = 0; i < colours.size(); ++i) {
    colours[i] = i < 2 ? palette[i] : png_color{static_cast<png_byte>(i), 9, 200};
  }
  if (!colours.empty()) png_set_PLTE(png, info, colours.data(), static_cast<int>(colours.size()));
  const png_byte alphas[] = {0, 128};
  const png_color_16 key = {0, 1, 1, 1, 1};
  if (transparent) png_set_tRNS(png, info, alphas, colours.empty() ? 0 : 2, &key);
  png_write_info(png, info);
  const std::size_t row = png_get_rowbytes(png, info);
  auto image = samples(row * kHeight);
  std::vector<png_bytep> rows;
  for (unsigned y = 0; y < kHeight; ++y) rows.push_back(image.data() + y * row);
  png_write_image(png, rows.data());
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

struct JpegKind {
  const char* name;
  int components = 3;
  bool progressive = false;
  int sampling_x = 1;
  int sampling_y = 1;
  unsigned restart = 0;
  bool optimized = false;
  bool rgb = false;
};

std::string jpeg_seed(const JpegKind& kind) {
  jpeg_compress_struct jpeg;
  jpeg_error_mgr errors;
  jpeg.err = jpeg_std_error(&errors);
  jpeg_create_compress(&jpeg);
  unsigned char* memory = nullptr;
  unsigned long size = 0;
  jpeg_mem_dest(&jpeg, &memory, &size);
  jpeg.image_width = kWidth;
  jpeg.image_height = kHeight;
  jpeg.input_components = kind.components;
  jpeg.in_color_space = kind.components == 1   ? JCS_GRAYSCALE
                        : kind.components == 3 ? JCS_RGB
                                               : JCS_CMYK;
  jpeg_set_defaults(&jpeg);
  if (kind.rgb) jpeg_set_colorspace(&jpeg, JCS_RGB);
  jpeg.comp_info[0].h_samp_factor = kind.sampling_x;
  jpeg.comp_info[0].v_samp_factor = kind.sampling_y;
  jpeg.restart_interval = kind.restart;
  jpeg.optimize_coding = kind.optimized ? TRUE : FALSE;
  if (kind.progressive) jpeg_simple_progression(&jpeg);
  jpeg_start_compress(&jpeg, TRUE);
  const auto row = static_cast<std::size_t>(kind.components) * kWidth;
  auto image = samples(row * kHeight);
  while (jpeg.next_scanline < kHeight) {
    JSAMPROW at = image.data() + jpeg.next_scanline * row;
    jpeg_write_scanlines(&jpeg, &at, 1);
  }
  jpeg_finish_compress(&jpeg);
  jpeg_destroy_compress(&jpeg);
  std::string bytes(reinterpret_cast<char*>(memory), size);
  std::free(memory);
  return bytes;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: image_seeds FOLDER\n", stderr);
    return 2;
  }
  const auto pngs = std::filesystem::path(argv[1]) / "png";
  const auto jpegs = std::filesystem::path(argv[1]) / "jpeg";
  std::filesystem::create_directories(pngs);
  std::filesystem::create_directories(jpegs);
  for (const int colour_type : {0, 2, 3, 4, 6}) {
    for (const int depth : {1, 2, 4, 8, 16}) {
      if (colour_type != 0 && depth < 8 && colour_type != 3) continue;
      if (colour_type == 3 && depth == 16) continue;
      for (const int interlace : {0, 1}) {
        for (const bool transparent : {false, true}) {
          if (transparent && colour_type >= 4) continue;
          const std::string name = std::to_string(colour_type) + "_" + std::to_string(depth) +
                                   (interlace == 1 ? "_adam7" : "") + (transparent ? "_t" : "");
          ccvt::test::put(pngs / name, png_seed(colour_type, depth, interlace, transparent));
        }
      }
    }
  }
  const JpegKind kinds[] = {
      {.name = "grey", .components = 1},
      {.name = "grey_progressive", .components = 1, .progressive = true},
      {.name = "colour"},
      {.name = "rgb", .rgb = true},
      {.name = "optimized", .optimized = true},
      {.name = "halved", .sampling_x = 2, .sampling_y = 2},
      {.name = "halved_across", .sampling_x = 2},
      {.name = "halved_down", .sampling_y = 2},
      {.name = "quartered", .sampling_x = 4},
      {.name = "restarts", .restart = 2},
      {.name = "progressive", .progressive = true},
      {.name = "progressive_halved", .progressive = true, .sampling_x = 2, .sampling_y = 2},
      {.name = "progressive_restarts", .progressive = true, .restart = 3},
      {.name = "cmyk", .components = 4},
  };
  for (const JpegKind& kind : kinds) ccvt::test::put(jpegs / kind.name, jpeg_seed(kind));
  return 0;
}
