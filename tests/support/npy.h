#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace ccvt::test {

/// The numbers as they lie in a file, of either byte order.
template <class Number>
std::string number_bytes(const std::vector<Number>& numbers, bool big_endian = false) {
  std::string bytes;
  for (const Number number : numbers) {
    std::string item(sizeof number, '\0');
    std::memcpy(item.data(), &number, sizeof number);
    if (big_endian) std::reverse(item.begin(), item.end());
    bytes += item;
  }
  return bytes;
}

/// An .npy file of version 1.0.
inline std::string npy_file(const std::string& descr, const std::string& shape,
                            const std::string& data, bool fortran_order = false) {
  const std::string header = "{'descr': '" + descr +
                             "', 'fortran_order': " + (fortran_order ? "True" : "False") +
                             ", 'shape': " + shape + ", }\n";
  const std::vector<std::uint16_t> length = {static_cast<std::uint16_t>(header.size())};
  return std::string("\x93NUMPY\x01\0", 8) + number_bytes(length) + header + data;
}

}  // namespace ccvt::test
