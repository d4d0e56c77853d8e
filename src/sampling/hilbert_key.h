#pragma once

#include <array>
#include <bit>
#include <cstdint>

namespace ccvt {

/// The place of a cell along a Hilbert curve through 2^20 cells in each of three dimensions, below
/// 2^60: the curve of hilbert.h, entered anywhere [Hamilton, Rau-Chaplin 2008].
inline std::uint64_t hilbert_key(const std::array<std::uint32_t, 3>& position) {
  constexpr unsigned kBits = 20;
  const auto rotate_left = [](unsigned x, unsigned by) {
    by %= 3;
    return ((x << by) | (x >> (3 - by))) & 7U;
  };
  const auto gray = [](unsigned x) { return x ^ (x >> 1); };
  std::uint64_t key = 0;
  unsigned entry = 0;
  unsigned direction = 0;
  for (unsigned bit = kBits; bit-- > 0;) {
    const unsigned corner = (position[0] >> bit & 1U) | (position[1] >> bit & 1U) << 1U |
                            (position[2] >> bit & 1U) << 2U;
    const unsigned code = rotate_left(corner ^ entry, 2 * (direction + 1));  // to the right
    const unsigned number = code ^ (code >> 1) ^ (code >> 2);                // gray(number) == code
    key = key << 3U | number;
    const unsigned inner = number == 0 ? 0 : gray((number - 1) & ~1U);
    const unsigned odd = (number & 1U) != 0 ? number : number - 1;
    const unsigned turn = number == 0 ? 0 : static_cast<unsigned>(std::countr_one(odd)) % 3;
    entry ^= rotate_left(inner, direction + 1);
    direction = (direction + turn + 1) % 3;
  }
  return key;
}

}  // namespace ccvt
