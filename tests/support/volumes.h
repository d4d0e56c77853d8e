#pragma once

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

/// Files of volumes, made from the definitions of their formats.
namespace ccvt::test {

template <class Value>
void put_at(std::string& bytes, std::size_t offset, Value value, bool swapped = false) {
  std::array<char, sizeof(Value)> raw{};
  std::memcpy(raw.data(), &value, sizeof(Value));
  if (swapped) std::reverse(raw.begin(), raw.end());
  std::copy(raw.begin(), raw.end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset));
}

/// The numbers, one behind the other.
template <class Value>
std::string bytes_of_values(const std::vector<Value>& values, bool swapped = false) {
  std::string bytes(values.size() * sizeof(Value), '\0');
  for (std::size_t i = 0; i < values.size(); ++i) {
    put_at(bytes, i * sizeof(Value), values[i], swapped);
  }
  return bytes;
}

/// A NIfTI-1 header and the four bytes behind it, for a volume with spacings 1, 2, 3.
inline std::string nifti1(std::array<int, 3> shape, int datatype, int bitpix,
                          bool swapped = false) {
  std::string h(352, '\0');
  put_at(h, 0, std::int32_t{348}, swapped);
  put_at(h, 40, std::int16_t{3}, swapped);
  for (std::size_t d = 0; d < 3; ++d) {
    put_at(h, 42 + 2 * d, static_cast<std::int16_t>(shape[d]), swapped);
    put_at(h, 80 + 4 * d, static_cast<float>(d + 1), swapped);
  }
  put_at(h, 70, static_cast<std::int16_t>(datatype), swapped);
  put_at(h, 72, static_cast<std::int16_t>(bitpix), swapped);
  put_at(h, 108, 352.0F, swapped);
  h.replace(344, 4, std::string("n+1\0", 4));
  return h;
}

/// The same in NIfTI-2.
inline std::string nifti2(std::array<int, 3> shape, int datatype, int bitpix,
                          bool swapped = false) {
  std::string h(544, '\0');
  put_at(h, 0, std::int32_t{540}, swapped);
  h.replace(4, 8, std::string("n+2\0\r\n\x1a\n", 8));
  put_at(h, 12, static_cast<std::int16_t>(datatype), swapped);
  put_at(h, 14, static_cast<std::int16_t>(bitpix), swapped);
  put_at(h, 16, std::int64_t{3}, swapped);
  for (std::size_t d = 0; d < 3; ++d) {
    put_at(h, 24 + 8 * d, std::int64_t{shape[d]}, swapped);
    put_at(h, 112 + 8 * d, static_cast<double>(d + 1), swapped);
  }
  put_at(h, 168, std::int64_t{544}, swapped);
  return h;
}

inline std::string gzipped(const std::string& bytes) {
  z_stream state = {};
  deflateInit2(&state, 9, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY);
  std::string packed(deflateBound(&state, bytes.size()) + 64, '\0');
  std::string input = bytes;
  state.next_in = reinterpret_cast<Bytef*>(input.data());
  state.avail_in = static_cast<uInt>(input.size());
  state.next_out = reinterpret_cast<Bytef*>(packed.data());
  state.avail_out = static_cast<uInt>(packed.size());
  deflate(&state, Z_FINISH);
  packed.resize(state.total_out);
  deflateEnd(&state);
  return packed;
}

}  // namespace ccvt::test
