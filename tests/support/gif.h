#pragma once

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

/// A reader of GIF89a, as far as frames of grey that fill the picture need it, written from the
/// format's description and not from the writer that it checks. Throws std::runtime_error.
namespace ccvt::test {

struct Gif {
  int width = 0;
  int height = 0;
  std::vector<std::vector<std::uint8_t>> frames;  ///< greys, row by row
};

class GifReader {
 public:
  explicit GifReader(std::string_view bytes) : bytes_(bytes) {}

  Gif read() {
    expect(take(6) == "GIF89a", "signature");
    Gif gif;
    gif.width = number();
    gif.height = number();
    const int flags = byte();
    expect((flags & 0x80) != 0, "global colours");
    take(2);
    const std::string_view colours = take(std::size_t{3} << ((flags & 7) + 1));
    for (int kind = byte(); kind != ';'; kind = byte()) {
      if (kind == 0x21) {
        byte();
        blocks();
        continue;
      }
      expect(kind == ',', "a frame");
      expect(number() == 0 && number() == 0 && number() == gif.width && number() == gif.height,
             "a frame that fills the picture");
      expect(byte() == 0, "no local colours, not interlaced");
      gif.frames.push_back(frame(colours));
      expect(gif.frames.back().size() ==
                 static_cast<std::size_t>(gif.width) * static_cast<std::size_t>(gif.height),
             "as many pixels as the picture has");
    }
    expect(at_ == bytes_.size(), "nothing behind the end");
    return gif;
  }

 private:
  static void expect(bool holds, const std::string& what) {
    if (!holds) throw std::runtime_error("GIF: expected " + what);
  }
  std::string_view take(std::size_t count) {
    expect(count <= bytes_.size() - at_, "more bytes");
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  int byte() { return static_cast<std::uint8_t>(take(1)[0]); }
  int number() {
    const int low = byte();
    return low + 256 * byte();
  }
  std::string blocks() {
    std::string all;
    for (int size = byte(); size > 0; size = byte()) all += take(static_cast<std::size_t>(size));
    return all;
  }

  std::vector<std::uint8_t> frame(std::string_view colours) {
    const int pixel_bits = byte();
    const std::string data = blocks();
    const std::size_t clear = std::size_t{1} << pixel_bits;
    std::vector<std::string> words;
    std::vector<std::uint8_t> greys;
    std::string before;
    std::size_t width = 0;
    const auto start = [&] {
      words.assign(clear + 2, "");
      for (std::size_t c = 0; c < clear; ++c) words[c] = std::string(1, static_cast<char>(c));
      before.clear();
      width = static_cast<std::size_t>(pixel_bits) + 1;
    };
    start();
    std::size_t bit = 0;
    while (true) {
      expect(bit + width <= 8 * data.size(), "an end of the codes");
      std::size_t code = 0;
      for (std::size_t k = 0; k < width; ++k, ++bit) {
        code |= static_cast<std::size_t>((data[bit / 8] >> (bit % 8)) & 1) << k;
      }
      if (code == clear + 1) break;
      if (code == clear) {
        start();
        continue;
      }
      expect(code < words.size() || (code == words.size() && !before.empty()),
             "a code that is known");
      const std::string word = code < words.size() ? words[code] : before + before[0];
      if (!before.empty() && words.size() < 4096) words.push_back(before + word[0]);
      if (words.size() == std::size_t{1} << width && width < 12) ++width;
      before = word;
      for (const char index : word) {
        const auto colour = 3 * static_cast<std::size_t>(index);
        expect(colour + 2 < colours.size() && colours[colour] == colours[colour + 1] &&
                   colours[colour] == colours[colour + 2],
               "a grey");
        greys.push_back(static_cast<std::uint8_t>(colours[colour]));
      }
    }
    expect(data.size() - bit / 8 <= 1, "no codes behind their end");
    return greys;
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
};

}  // namespace ccvt::test
