#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "ccvt/export.h"
#include "io/input_file.h"

/// NumPy array files.
namespace ccvt::io {

/// The header of a NumPy array file.
struct NpyHeader {
  std::string descr;                 ///< as NumPy writes it, "<f4" for float32
  std::vector<std::uint64_t> shape;  ///< at most 32 numbers
  bool fortran_order = false;        ///< the first index varies fastest, not the last
  std::uint64_t data_bytes = 0;      ///< bytes of the file behind the header
};

/// Reads the header and leaves `file` at the data. Throws InvalidInput when it is malformed, or of
/// a version other than 1.0, 2.0 and 3.0.
NpyHeader read_npy_header(InputFile& file);

enum class NpyType {
  boolean,
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float16,
  float32,
  float64
};

/// How a number is stored.
struct NpyItem {
  NpyType type = NpyType::float64;
  std::size_t bytes = 8;
  bool big_endian = false;  ///< false for items of one byte
};

/// Nothing for what is no number of these types.
std::optional<NpyItem> parse_npy_descr(std::string_view descr);

/// What an IEEE 754 binary16 number stands for, exactly.
float float_of_half(std::uint16_t half);

/// Throws InvalidInput unless the data of `header` are exactly the numbers of its shape, each
/// `item_bytes` wide.
void check_npy_size(const InputFile& file, const NpyHeader& header, std::size_t item_bytes);

/// "(3, 4)" or "(3,)".
std::string shape_text(const std::vector<std::uint64_t>& shape);

/// The bytes in front of the data of a version 1.0 file: a multiple of 64 of them.
CCVT_EXPORT std::string format_npy_header(std::string_view descr,
                                          const std::vector<std::uint64_t>& shape);

}  // namespace ccvt::io
