#pragma once

#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <vector>

#include "io/input_file.h"
#include "io/npy.h"

namespace ccvt::io {

/// Hands the next `count` numbers of `file`, stored as Stored, to visit(number), block by block.
template <class Stored, class Visit>
void read_stored(InputFile& file, bool big_endian, std::uint64_t count, const Visit& visit) {
  static_assert(std::endian::native == std::endian::little);
  std::vector<Stored> block(std::min<std::uint64_t>(count, std::uint64_t{1} << 16));
  while (count > 0) {
    block.resize(std::min<std::uint64_t>(count, block.size()));
    file.read(block.data(), block.size() * sizeof(Stored));
    for (Stored number : block) {
      if (big_endian) {
        std::byte bytes[sizeof(Stored)];
        std::memcpy(bytes, &number, sizeof number);
        std::reverse(bytes, bytes + sizeof number);
        std::memcpy(&number, bytes, sizeof number);
      }
      visit(number);
    }
    count -= block.size();
  }
}

/// The same for any type of an .npy file: a bool comes as an int of 0 or 1, a float16 as a float.
template <class Visit>
void read_npy_numbers(InputFile& file, const NpyItem& item, std::uint64_t count,
                      const Visit& visit) {
  switch (item.type) {
    case NpyType::boolean:
      return read_stored<std::uint8_t>(file, false, count,
                                       [&](std::uint8_t byte) { visit(byte == 0 ? 0 : 1); });
    case NpyType::int8:
      return read_stored<std::int8_t>(file, false, count, visit);
    case NpyType::uint8:
      return read_stored<std::uint8_t>(file, false, count, visit);
    case NpyType::int16:
      return read_stored<std::int16_t>(file, item.big_endian, count, visit);
    case NpyType::uint16:
      return read_stored<std::uint16_t>(file, item.big_endian, count, visit);
    case NpyType::int32:
      return read_stored<std::int32_t>(file, item.big_endian, count, visit);
    case NpyType::uint32:
      return read_stored<std::uint32_t>(file, item.big_endian, count, visit);
    case NpyType::int64:
      return read_stored<std::int64_t>(file, item.big_endian, count, visit);
    case NpyType::uint64:
      return read_stored<std::uint64_t>(file, item.big_endian, count, visit);
    case NpyType::float16:
      return read_stored<std::uint16_t>(file, item.big_endian, count,
                                        [&](std::uint16_t half) { visit(float_of_half(half)); });
    case NpyType::float32:
      return read_stored<float>(file, item.big_endian, count, visit);
    case NpyType::float64:
      return read_stored<double>(file, item.big_endian, count, visit);
  }
}

}  // namespace ccvt::io
