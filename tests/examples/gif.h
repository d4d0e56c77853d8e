// An animated GIF of grey pictures, for relax_gif.cpp: 16 greys, compressed as GIF89a asks (LZW).
#pragma once

#include <ccvt/io.h>

#include <cstddef>
#include <map>
#include <string>
#include <utility>
#include <vector>

/// What follows a frame's header: codes of 5 to 12 bits for ever longer words of pixels, lowest
/// bits first, in blocks of at most 255 bytes.
inline std::string compressed(const ccvt::Image& frame) {
  constexpr int clear = 16, end = 17, first_word = 18, longest = 4096;
  std::string bytes;
  unsigned waiting = 0;  // bits that do not fill a byte yet
  int bits = 0, width = 5, next = first_word;
  std::map<std::pair<int, int>, int> words;  // a word and the pixel after it: a longer word
  const auto put = [&](int code) {
    waiting |= static_cast<unsigned>(code) << bits;
    for (bits += width; bits >= 8; bits -= 8, waiting >>= 8) {
      bytes += static_cast<char>(waiting & 255);
    }
  };
  const auto start_again = [&] {
    put(clear);
    words.clear();
    next = first_word;
    width = 5;
  };
  const auto put_word = [&](int code) {
    put(code);
    if (next == 1 << width) ++width;  // the reader knows as many words by now
    if (++next == longest) start_again();
  };

  start_again();
  int word = -1;
  for (const float value : frame.values) {
    const int pixel = static_cast<int>(15 * value + 0.5F);
    const auto longer = words.find({word, pixel});
    if (word < 0) {
      word = pixel;
    } else if (longer != words.end()) {
      word = longer->second;
    } else {
      words[{word, pixel}] = next;
      put_word(word);
      word = pixel;
    }
  }
  put_word(word);
  put(end);
  if (bits > 0) bytes += static_cast<char>(waiting);

  std::string blocks = "\4";  // bits of a pixel
  for (std::size_t from = 0; from < bytes.size(); from += 255) {
    const std::string block = bytes.substr(from, 255);
    blocks += static_cast<char>(block.size()) + block;
  }
  return blocks + '\0';
}

/// Frames of equal size, each shown for so many hundredths of a second, again and again.
inline std::string animated_gif(const std::vector<ccvt::Image>& frames, int hundredths) {
  const auto number = [](int n) {
    return std::string{static_cast<char>(n), static_cast<char>(n >> 8)};
  };
  const std::string size = number(frames.at(0).width) + number(frames.at(0).height);
  std::string gif = "GIF89a" + size + std::string("\xF3\0\0", 3);  // 16 colours
  for (int grey = 0; grey < 16; ++grey) gif += std::string(3, static_cast<char>(17 * grey));
  gif += std::string("\x21\xFF\x0BNETSCAPE2.0\3\1\0\0\0", 19);  // for ever
  for (const ccvt::Image& frame : frames) {
    gif += std::string("\x21\xF9\4\0", 4) + number(hundredths) + std::string("\0\0", 2);
    gif += ',' + number(0) + number(0) + size + '\0' + compressed(frame);
  }
  return gif + ';';
}
