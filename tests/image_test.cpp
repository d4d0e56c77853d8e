#include <doctest/doctest.h>
#include <sys/resource.h>
#include <zlib.h>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "ccvt/io.h"
#include "support/files.h"
#include "support/jpeg.h"
#include "support/message.h"
#include "support/png.h"

using namespace std::string_literals;

namespace ccvt::test {
namespace {

namespace fs = std::filesystem;

std::string refusal_of(const fs::path& path) {
  return message_of([&] { read_image(path); });
}

/// A zlib stream of `count` zero bytes.
std::string compressed_zeros(std::size_t count) {
  const std::vector<Bytef> zeros(count);
  std::string stream(compressBound(count), '\0');
  auto size = static_cast<uLongf>(stream.size());
  compress2(reinterpret_cast<Bytef*>(stream.data()), &size, zeros.data(), count, 9);
  stream.resize(size);
  return stream;
}

struct Bad {
  std::string what;
  std::string bytes;
  std::string expected;
};

void check_refusals(const std::vector<Bad>& pictures) {
  const TemporaryDirectory directory;
  const fs::path path = directory / "p.img";
  for (const Bad& bad : pictures) {
    CAPTURE(bad.what);
    const std::string message = refusal_of(put(path, bad.bytes));
    CAPTURE(message);
    CHECK(message.rfind(path.string() + ": ", 0) == 0);
    CHECK(message.find(bad.expected) != std::string::npos);
    CHECK(message.find('\n') == std::string::npos);
    CHECK(message_of([&] { read_colour_image(path); }) == message);
  }
}

}  // namespace

TEST_SUITE_BEGIN("io");

TEST_CASE("grey, colour, alpha, 8 and 16 bits, palettes") {
  const TemporaryDirectory directory;
  const std::string palette =
      png_chunk("PLTE", std::string("\xFF\xFF\xFF\x00\x00\x00\xFF\x00\x00", 9));
  struct Case {
    std::string png;
    std::vector<double> expected;
  };
  const double half = 0x8000 / 65535.0;
  const Case cases[] = {
      {make_png(3, 1, 8, 0, {0, 51, 255}), {0, 0.2, 1}},
      {make_png(1, 2, 8, 0, {0, 255}), {0, 1}},
      {make_png(3, 1, 16, 0, {0, 0x8000, 65535}), {0, half, 1}},
      {make_png(2, 1, 16, 0, {257, 258}), {257 / 65535.0, 258 / 65535.0}},
      {make_png(3, 1, 8, 4, {0, 0, 0, 51, 255, 255}), {1, 0.8, 1}},
      {make_png(2, 1, 16, 4, {0, 0x8000, 0x8000, 65535}), {1 - half, half}},
      {make_png(4, 1, 8, 2, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255}),
       {0.2126, 0.7152, 0.0722, 1}},
      {make_png(2, 1, 8, 6, {255, 0, 0, 102, 9, 9, 9, 0}), {0.6 + 0.4 * 0.2126, 1}},
      {make_png(1, 1, 16, 6, {0, 65535, 0, 65535}), {0.7152}},
      {make_png(3, 1, 8, 3, {0, 1, 2}, palette), {1, 0, 0.2126}},
      {make_png(3, 1, 8, 3, {0, 1, 2}, palette + png_chunk("tRNS", std::string("\xFF\x00\xFF", 3))),
       {1, 1, 0.2126}},
      {make_png(3, 1, 2, 0, {0, 1, 3}, png_chunk("tRNS", "\0\1"s)), {0, 1, 1}},
      {make_png(2, 1, 16, 0, {257, 258}, png_chunk("tRNS", "\1\1"s)), {1, 258 / 65535.0}},
      {make_png(2, 1, 8, 2, {0, 0, 0, 0, 0, 1}, png_chunk("tRNS", std::string(6, '\0'))),
       {1, 0.0722 / 255}},
  };
  for (const auto& [png, expected] : cases) {
    const Image image = read_image(put(directory / "p.png", png));
    REQUIRE(image.values.size() == expected.size());
    for (std::size_t i = 0; i < expected.size(); ++i) {
      CHECK(static_cast<double>(image.values[i]) == doctest::Approx(expected[i]).epsilon(1e-6));
      if (expected[i] == 1) CHECK(image.values[i] == 1.0F);  // white has no ink at all
    }
  }
}

TEST_CASE("every kind of PNG, interlaced or not, has the pixels that were put into it") {
  const TemporaryDirectory directory;
  struct Kind {
    int colour_type;
    int channels;
    std::vector<int> depths;
  };
  const Kind kinds[] = {{0, 1, {1, 2, 4, 8, 16}},
                        {2, 3, {8, 16}},
                        {3, 1, {1, 2, 4, 8}},
                        {4, 2, {8, 16}},
                        {6, 4, {8, 16}}};
  const std::uint32_t width = 13;
  const std::uint32_t height = 11;
  for (const Kind& kind : kinds) {
    const auto channels = static_cast<std::size_t>(kind.channels);
    for (const int depth : kind.depths) {
      CAPTURE(kind.colour_type);
      CAPTURE(depth);
      const unsigned full = (1U << static_cast<unsigned>(depth)) - 1;
      std::vector<unsigned> samples(width * height * channels);
      for (std::size_t i = 0; i < samples.size(); ++i) {
        samples[i] = static_cast<unsigned>(i * 2654435761U >> 7U) & full;
      }
      std::string palette;
      for (unsigned i = 0; kind.colour_type == 3 && i <= full; ++i) {
        for (const unsigned factor : {3U, 5U, 7U}) palette += static_cast<char>(i * factor & 0xFFU);
      }
      const std::string extra = palette.empty() ? "" : png_chunk("PLTE", palette);
      for (const bool interlaced : {false, true}) {
        CAPTURE(interlaced);
        const ColourImage image = read_colour_image(
            put(directory / "p.png",
                make_png(width, height, depth, kind.colour_type, samples, extra, interlaced)));
        REQUIRE(image.rgb.size() == 3 * width * height);
        for (std::size_t k = 0; k < image.rgb.size(); ++k) {
          const unsigned* const pixel = &samples[k / 3 * channels];
          const double opaque =
              channels % 2 == 0 ? static_cast<double>(pixel[channels - 1]) / full : 1;
          double value = static_cast<double>(pixel[channels >= 3 ? k % 3 : 0]) / full;
          if (!palette.empty()) {
            value = static_cast<unsigned char>(palette[3 * *pixel + k % 3]) / 255.0;
          }
          CHECK(std::abs(image.rgb[k] - 255 * (value * opaque + 1 - opaque)) <= 0.5 + 1e-9);
        }
      }
    }
  }
}

TEST_CASE("JPEG, and contents rather than names") {
  const TemporaryDirectory directory;
  const fs::path data = CCVT_TEST_DATA;
  const Image gradient = read_image(data / "gradient.jpg");
  CHECK(gradient.width == 24);
  CHECK(gradient.height == 16);
  CHECK(gradient(0, 0) == doctest::Approx(0.2126).epsilon(0.1));
  CHECK(gradient(23, 15) == doctest::Approx(0.7152 + 0.0722 / 4).epsilon(0.1));
  const Image grey = read_image(data / "grey_progressive.jpg");
  CHECK(grey(3, 5) == doctest::Approx(128.0 / 255).epsilon(0.02));
  fs::copy(data / "gradient.jpg", directory / "named.png");
  CHECK(read_image(directory / "named.png").values == gradient.values);
}

TEST_CASE("pictures are turned upright as their Exif data say") {
  const TemporaryDirectory directory;
  const std::string stored = get(fs::path(CCVT_TEST_DATA) / "gradient.jpg");
  const Image as_stored = read_image(fs::path(CCVT_TEST_DATA) / "gradient.jpg");
  const auto with_exif = [&](const std::string& tiff) {
    const std::string segment = jpeg_segment(0xE1, "Exif\0\0"s + tiff);
    return put(directory / "p.jpg", stored.substr(0, 2) + segment + stored.substr(2));
  };
  const auto little = [](char orientation) {
    return "II*\0\x8\0\0\0\2\0\x0F\1\2\0\1\0\0\0x\0\0\0\x12\1\3\0\1\0\0\0"s + orientation +
           "\0\0\0"s;
  };
  const auto big = [](char orientation) {
    return "MM\0*\0\0\0\x8\0\1\1\x12\0\3\0\0\0\1\0"s + orientation + "\0\0"s;
  };
  // Where the pixel (x, y) of the upright picture is stored, the last of columns c and of rows r.
  const auto place = [](int orientation, int x, int y, int c, int r) -> std::pair<int, int> {
    switch (orientation) {
      case 2:
        return {c - x, y};
      case 3:
        return {c - x, r - y};
      case 4:
        return {x, r - y};
      case 5:
        return {y, x};
      case 6:
        return {y, r - x};
      case 7:
        return {c - y, r - x};
      case 8:
        return {c - y, x};
      default:
        return {x, y};
    }
  };
  for (int orientation = 1; orientation <= 8; ++orientation) {
    for (const std::string& tiff :
         {little(static_cast<char>(orientation)), big(static_cast<char>(orientation))}) {
      CAPTURE(orientation);
      const fs::path path = with_exif(tiff);
      const Image image = read_image(path);
      REQUIRE(image.width == (orientation < 5 ? 24 : 16));
      REQUIRE(image.height == (orientation < 5 ? 16 : 24));
      bool right = true;
      for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
          const auto [column, row] = place(orientation, x, y, 23, 15);
          right = right && image(x, y) == as_stored(column, row);
        }
      }
      CHECK(right);
      const ColourImage colours = read_colour_image(path);
      CHECK(colours.width == image.width);
      CHECK(colours.rgb.size() == 3 * image.values.size());
    }
  }
  // Of PNG, before the picture's data or behind.
  const auto with_chunk = [](const std::string& chunk) {
    return make_png(3, 2, 8, 0, {0, 51, 102, 153, 204, 255}, chunk);
  };
  const std::string upright = with_chunk("");
  const std::string exif = png_chunk("eXIf", little(6));
  const std::string before = with_chunk(exif);
  const std::string end = png_chunk("IEND", "");
  const std::string behind = upright.substr(0, upright.size() - end.size()) + exif + end;
  for (const std::string& bytes : {before, behind}) {
    const Image image = read_image(put(directory / "p.png", bytes));
    CHECK(image.width == 2);
    CHECK(image.height == 3);
    CHECK(image.values == std::vector<float>{0.6F, 0, 0.8F, 0.2F, 1, 0.4F});
  }
  for (const std::string& nothing : {"II*"s, ""s, little(9)}) {
    const std::string bytes = with_chunk(png_chunk("eXIf", nothing));
    CHECK(read_image(put(directory / "p.png", bytes)).width == 3);
  }
  CHECK(read_image(put(directory / "p.png", upright + exif)).width == 3);  // behind the end
  // What says nothing, or nothing that can be.
  const std::string right = little(6);
  for (std::size_t size = 0; size < right.size() - 3; ++size) {
    CHECK(read_image(with_exif(right.substr(0, size))).values == as_stored.values);
  }
  for (const std::string& tiff :
       {little(0), little(9), "II*\0\xFF\xFF\xFF\xFF"s, "JJ" + right.substr(2)}) {
    CHECK(read_image(with_exif(tiff)).values == as_stored.values);
  }
}

TEST_CASE("every truncation of a picture is refused") {
  const TemporaryDirectory directory;
  const std::string whole[] = {make_png(2, 2, 8, 0, {0, 51, 102, 255}),
                               make_png(2, 2, 8, 0, {0, 51, 102, 255}, "", true),
                               get(fs::path(CCVT_TEST_DATA) / "gradient.jpg"),
                               get(fs::path(CCVT_TEST_DATA) / "grey_progressive.jpg")};
  for (const std::string& bytes : whole) {
    REQUIRE(bytes.size() > 60);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const std::string message = refusal_of(put(directory / "p.png", bytes.substr(0, size)));
      CAPTURE(size);
      CAPTURE(message);
      CHECK(message.rfind((directory / "p.png").string() + ": ", 0) == 0);
      if (size > 3) CHECK(message.find("truncated") != std::string::npos);
    }
    CHECK(refusal_of(put(directory / "p.png", bytes)) == "nothing thrown");
    CHECK(refusal_of(put(directory / "p.png", bytes + "more")) == "nothing thrown");
  }
}

TEST_CASE("every damaged byte of a PNG is refused") {
  const TemporaryDirectory directory;
  const std::string good =
      make_png(2, 2, 8, 0, {0, 51, 102, 255}, png_chunk("tEXt", "Title\0none"s));
  REQUIRE(refusal_of(put(directory / "p.png", good)) == "nothing thrown");
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string bad = good;
    bad[at] = static_cast<char>(bad[at] ^ 0x10);
    CAPTURE(at);
    CHECK(refusal_of(put(directory / "p.png", bad)) != "nothing thrown");
  }
}

TEST_CASE("pictures that claim too much are refused before they are decoded") {
  const std::string pixel = png_chunk("IDAT", stored("\0\0"s));
  const auto claim = [&](std::uint32_t width, std::uint32_t height, bool interlaced = false) {
    return png_of(png_header(width, height, 8, 0, interlaced) + pixel);
  };
  const auto jpeg = [](std::size_t width, std::size_t height, unsigned process = 0) {
    return make_jpeg(jpeg_tables() + jpeg_frame(process, width, height) + jpeg_scan(1, 1, 2));
  };
  check_refusals({
      {"PNG", claim(10000, 10000), "10000 x 10000 pixels, more than its 70 bytes can hold"},
      {"interlaced PNG", claim(10000, 10000, true), "more than its 70 bytes"},
      {"largest PNG", claim(0x7FFFFFFF, 0x7FFFFFFF), "2147483647 pixels; at most 268435456"},
      {"PNG beyond 31 bits", claim(0xFFFFFFFF, 1), "unsigned integer out of range"},
      {"PNG without columns", claim(0, 5), "width is zero"},
      {"PNG with less than it claims", claim(2, 2), "Not enough image data"},
      {"JPEG", jpeg(4000, 4000), "4000 x 4000 pixels, more than its"},
      {"progressive JPEG", jpeg(4000, 4000, 2), "4000 x 4000 pixels, more than its"},
      {"largest JPEG", jpeg(65500, 65500), "65500 x 65500 pixels; at most 268435456"},
      {"JPEG that libjpeg finds too large", jpeg(65535, 1), "more than 65500 pixels a side"},
      {"JPEG without rows", jpeg(5, 0), "damaged JPEG: Empty"},
      {"JPEG with less than it claims", jpeg(80, 80), "damaged JPEG"},
      {"other", "GIF89a", "neither PNG nor JPEG"},
  });
}

TEST_CASE("a PNG that unpacks to more than its picture is refused, at once") {
  std::string bomb = compressed_zeros(std::size_t{32} << 20U);
  // Who unpacks on to here finds that this is no stream, and says so.
  std::fill(bomb.begin() + 20000, bomb.end(), '\xFF');
  std::string split;
  for (std::size_t at = 0; at < bomb.size(); at += 1000) {
    split += png_chunk("IDAT", bomb.substr(at, 1000));
  }
  check_refusals({
      {"bomb", png_of(png_header(1, 1, 8, 0) + png_chunk("IDAT", bomb)), "Too much image data"},
      {"interlaced", png_of(png_header(1, 1, 8, 0, true) + png_chunk("IDAT", bomb)), "Too much"},
      {"in pieces", png_of(png_header(1, 1, 8, 0) + split), "Too much image data"},
      {"a byte", png_of(png_header(1, 1, 8, 0) + png_chunk("IDAT", stored("\0\0\0"s))),
       "Too much image data"},
      {"after the stream",
       png_of(png_header(1, 1, 8, 0) + png_chunk("IDAT", stored("\0\0"s) + std::string(9000, 'x'))),
       "Extra compressed data"},
  });
}

TEST_CASE("texts and profiles of a PNG are passed over, however large") {
  const TemporaryDirectory directory;
  const std::string bomb = compressed_zeros(std::size_t{32} << 20U);
  const std::string extra = png_chunk("iCCP", "p\0\0"s + bomb) +
                            png_chunk("zTXt", "t\0\0"s + bomb) +
                            png_chunk("prVt", std::string(9'000'000, 'x'));
  const Image image = read_image(put(directory / "p.png", make_png(1, 1, 8, 0, {51}, extra)));
  CHECK(image.values == std::vector<float>{0.2F});
}

TEST_CASE("damaged and unusual PNGs are refused") {
  const std::string pixel = png_chunk("IDAT", stored("\0\0"s));
  const std::string header = png_header(1, 1, 8, 0);
  std::string wrong_sum = stored("\0\0"s);
  wrong_sum.back() = static_cast<char>(wrong_sum.back() ^ 1);
  check_refusals({
      {"no header", png_of(pixel), "damaged PNG: IDAT: Missing IHDR"},
      {"no pixels", png_of(header), "damaged PNG"},
      {"two headers", png_of(header + header + pixel), "damaged PNG: IHDR: out of place"},
      {"no palette", png_of(png_header(1, 1, 8, 3) + pixel), "damaged PNG: IDAT: Missing PLTE"},
      {"12 bits", png_of(png_header(1, 1, 12, 0) + pixel), "Invalid bit depth"},
      {"colour type 5", png_of(png_header(1, 1, 8, 5) + pixel), "Invalid color type"},
      {"unknown critical chunk", png_of(header + png_chunk("NEWS", "x") + pixel), "unhandled"},
      {"sum of the stream", png_of(header + png_chunk("IDAT", wrong_sum)), "incorrect data check"},
      {"filter 9", png_of(header + png_chunk("IDAT", stored("\x09\0"s))), "bad adaptive filter"},
      {"transparency of a colour that no pixel has",
       png_of(header + png_chunk("tRNS", "\0\0\0"s) + pixel), "damaged PNG: tRNS: invalid"},
  });
}

TEST_CASE("damaged and unusual JPEGs are refused") {
  const std::string frame = jpeg_frame(0, 8, 8);
  const std::string colour = jpeg_frame(0, 8, 8, 3);
  const std::string scan = jpeg_scan(1, 1, 2);
  const auto progressive = [&](int scans) {
    std::string segments = jpeg_tables() + jpeg_frame(2, 8, 8);
    for (int i = 0; i < scans; ++i) segments += jpeg_scan(1, 1, 1, 0);
    return make_jpeg(segments);
  };
  const auto process = [&](unsigned number, int components = 1, int precision = 8) {
    return make_jpeg(jpeg_tables() + jpeg_frame(number, 8, 8, components, precision) +
                     jpeg_scan(1, components, 8));
  };
  const std::string whole = make_jpeg(jpeg_tables() + frame + scan);
  const TemporaryDirectory directory;
  for (const std::string& good : {whole, progressive(100), process(1), process(0, 3)}) {
    REQUIRE(refusal_of(put(directory / "p.jpg", good)) == "nothing thrown");
    CHECK(read_colour_image(directory / "p.jpg").rgb == std::vector<std::uint8_t>(192, 128));
  }
  check_refusals({
      {"more than 256 codes",
       make_jpeg(jpeg_huffman(1, std::string(14, '\0') + "\xFF\xFF") + whole.substr(2)),
       "damaged JPEG: Bogus Huffman table"},
      {"more codes than bits allow",
       make_jpeg(jpeg_huffman(0, "\5" + std::string(15, '\0')) + jpeg_quantization() +
                 jpeg_huffman(1, "\1" + std::string(15, '\0')) + frame + scan),
       "damaged JPEG: Bogus Huffman table"},
      {"no quantization", make_jpeg(jpeg_codes() + frame + scan),
       "damaged JPEG: Quantization table 0x00 was not defined"},
      {"no codes", make_jpeg(jpeg_quantization() + jpeg_frame(2, 8, 8) + jpeg_scan(1, 1, 1, 0)),
       "damaged JPEG: Huffman table 0x00 was not defined"},
      {"two frames", make_jpeg(jpeg_tables() + jpeg_frame(0, 9000, 9000) + frame + scan),
       "two SOF"},
      {"a frame after the scan", make_jpeg(jpeg_tables() + frame + scan + frame), "two SOF"},
      {"no frame", make_jpeg(jpeg_tables() + scan), "damaged JPEG"},
      {"no scan", make_jpeg(jpeg_tables() + frame), "damaged JPEG"},
      {"101 scans", progressive(101), "more than 100 scans"},
      {"a scan more than components", make_jpeg(jpeg_tables() + frame + scan + scan),
       "damaged JPEG"},
      {"a component without a scan",
       make_jpeg(jpeg_tables() + colour + jpeg_scan(1, 1, 2) + jpeg_scan(2, 1, 2)),
       "no scan has component 3 of 3"},
      {"a scan of no component", make_jpeg(jpeg_tables() + frame + jpeg_scan(2, 1, 2)),
       "damaged JPEG"},
      {"coefficients before the mean of the block",
       make_jpeg(jpeg_tables() + jpeg_frame(2, 8, 8) + jpeg_segment(0xDA, "\1\1\0\1\5\0"s) +
                 "\x7F"),
       "damaged JPEG: Inconsistent progression"},
      {"wrong restart marker",
       make_jpeg(jpeg_tables() + jpeg_segment(0xDD, "\0\1"s) + jpeg_frame(0, 16, 8) +
                 jpeg_scan(1, 1, 2) + "\xFF\xD3\x3F"),
       "damaged JPEG: Corrupt JPEG data: found marker 0xd3"},
      {"a code that no table has",
       make_jpeg(jpeg_tables() + frame + jpeg_scan(1, 1, 0) + "\x55\x55\x55\x55"),
       "bad Huffman code"},
      {"12 bits", process(1, 1, 12), "of 12 bits a sample"},
      {"lossless", process(3), "lossless or hierarchical"},
      {"hierarchical", process(5), "lossless or hierarchical"},
      {"arithmetic codes", process(9), "arithmetic codes"},
      {"two components", process(0, 2), "of 2 components"},
      {"CMYK", process(0, 4), "CMYK"},
  });
}

TEST_CASE("oddities of JPEGs that leave the pixels as they are") {
  const TemporaryDirectory directory;
  const std::string colour = jpeg_tables() + jpeg_frame(0, 8, 8, 3);
  const std::string scan = jpeg_scan(1, 3, 6);
  const std::string pictures[] = {
      make_jpeg(jpeg_segment(0xE0, "JFIF\0\7\0\0\0\1\0\1\0\0"s) + colour + scan),
      make_jpeg(jpeg_segment(0xEE, "Adobe\0\x64\0\0\0\0\7"s) + colour + scan),
      make_jpeg(colour + jpeg_scan(1, 3, 6, 0)),         // says that blocks have one coefficient
      make_jpeg(colour + scan + std::string(40, '\0')),  // padding before the end
      make_jpeg(colour + jpeg_segment(0xFE, "\xFF\xD9"s) + scan),
  };
  for (const std::string& jpeg : pictures) {
    CHECK(read_colour_image(put(directory / "p.jpg", jpeg)).rgb ==
          std::vector<std::uint8_t>(192, 128));
  }
}

TEST_CASE("a picture that cannot be written leaves the old file in place") {
  const TemporaryDirectory directory;
  const fs::path target = put(directory / "p.png", "old");
  ColourImage image{512, 512, std::vector<std::uint8_t>(3 * 512 * 512)};
  std::uint32_t state = 1;
  for (auto& value : image.rgb) {
    state = state * 1664525 + 1013904223;
    value = static_cast<std::uint8_t>(state >> 24U);
  }
  struct rlimit before = {};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
  struct rlimit small = before;
  small.rlim_cur = 100000;
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  const std::string message = message_of([&] { write_png(target, image); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, old_handler);
  CHECK(message.rfind("IoError: " + target.string() + ": cannot be written: ", 0) == 0);
  CHECK(get(target) == "old");
  CHECK(directory.entries() == 1);
  write_png(target, image);
  CHECK(read_colour_image(target).rgb == image.rgb);
}

TEST_SUITE_END();

}  // namespace ccvt::test
