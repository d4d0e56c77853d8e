#include "io/npy.h"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <system_error>

namespace ccvt::io {

// Headers and data are copied as they lie in memory.
static_assert(std::endian::native == std::endian::little);

namespace {

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::uint32_t kLongestHeader = 1U << 20;
constexpr std::size_t kMostDimensions = 32;

/// Reads the dictionary of a header: a Python literal with three known keys.
class HeaderParser {
 public:
  HeaderParser(const InputFile& file, std::string_view text) : file_(file), rest_(text) {}

  void parse(NpyHeader& header) {
    bool descr = false;
    bool order = false;
    bool shape = false;
    expect('{');
    while (!accept('}')) {
      const std::string key = string();
      expect(':');
      if (key == "descr" && !descr) {
        descr = true;
        if (peek() == '[') file_.fail("holds records (a structured dtype), not plain numbers");
        header.descr = string();
      } else if (key == "fortran_order" && !order) {
        order = true;
        header.fortran_order = boolean();
      } else if (key == "shape" && !shape) {
        shape = true;
        header.shape = tuple();
      } else {
        malformed();
      }
      if (!accept(',') && peek() != '}') malformed();
    }
    skip_blanks();
    if (!rest_.empty() || !descr || !order || !shape) malformed();
  }

 private:
  [[noreturn]] void malformed() const { file_.fail("has a malformed .npy header"); }

  void skip_blanks() {
    const std::size_t blanks = rest_.find_first_not_of(" \t\r\n");
    rest_.remove_prefix(blanks == std::string_view::npos ? rest_.size() : blanks);
  }
  char peek() {
    skip_blanks();
    return rest_.empty() ? '\0' : rest_.front();
  }
  bool accept(char c) {
    if (peek() != c) return false;
    rest_.remove_prefix(1);
    return true;
  }
  void expect(char c) {
    if (!accept(c)) malformed();
  }
  std::string string() {
    const char quote = peek();
    if (quote != '\'' && quote != '"') malformed();
    const std::size_t end = rest_.find(quote, 1);
    if (end == std::string_view::npos) malformed();
    std::string result(rest_.substr(1, end - 1));
    rest_.remove_prefix(end + 1);
    return result;
  }
  bool boolean() {
    skip_blanks();
    for (const bool value : {true, false}) {
      const std::string_view word = value ? "True" : "False";
      if (rest_.substr(0, word.size()) == word) {
        rest_.remove_prefix(word.size());
        return value;
      }
    }
    malformed();
  }
  std::vector<std::uint64_t> tuple() {
    std::vector<std::uint64_t> result;
    expect('(');
    while (!accept(')')) {
      if (peek() == '-') file_.fail("has a negative number in its shape");
      std::uint64_t value = 0;
      const auto [end, error] = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value);
      if (error == std::errc::result_out_of_range) file_.fail("has a shape beyond 64 bits");
      if (error != std::errc() || result.size() == kMostDimensions) malformed();
      rest_ = {end, rest_.data() + rest_.size()};
      accept('L');  // as Python 2 wrote them
      result.push_back(value);
      if (!accept(',') && peek() != ')') malformed();
    }
    return result;
  }

  const InputFile& file_;
  std::string_view rest_;
};

}  // namespace

NpyHeader read_npy_header(InputFile& file) {
  unsigned char start[8] = {};
  if (file.read_some(start, sizeof start) < sizeof start ||
      std::memcmp(start, kMagic.data(), kMagic.size()) != 0) {
    file.fail("is not an .npy file: it does not start with \\x93NUMPY");
  }
  const int major = start[6];
  if (major < 1 || major > 3 || start[7] != 0) {
    file.fail("is of .npy version " + std::to_string(major) + "." + std::to_string(start[7]) +
              "; 1.0, 2.0 and 3.0 can be read");
  }
  const std::size_t length_bytes = major == 1 ? 2 : 4;
  std::uint32_t length = 0;
  file.read(&length, length_bytes);
  const std::uint64_t before = sizeof start + length_bytes;
  if (length > kLongestHeader || before + length > file.size()) {
    file.fail("is truncated: its header claims " + std::to_string(length) + " bytes");
  }
  std::string text(length, '\0');
  file.read(text.data(), text.size());
  NpyHeader header;
  HeaderParser(file, text).parse(header);
  header.data_bytes = file.size() - before - length;
  return header;
}

std::optional<NpyItem> parse_npy_descr(std::string_view descr) {
  struct Code {
    std::string_view text;
    NpyType type;
    std::size_t bytes;
  };
  constexpr std::array<Code, 12> codes = {{{"b1", NpyType::boolean, 1},
                                           {"i1", NpyType::int8, 1},
                                           {"u1", NpyType::uint8, 1},
                                           {"i2", NpyType::int16, 2},
                                           {"u2", NpyType::uint16, 2},
                                           {"i4", NpyType::int32, 4},
                                           {"u4", NpyType::uint32, 4},
                                           {"i8", NpyType::int64, 8},
                                           {"u8", NpyType::uint64, 8},
                                           {"f2", NpyType::float16, 2},
                                           {"f4", NpyType::float32, 4},
                                           {"f8", NpyType::float64, 8}}};
  if (descr.empty() || std::string_view("<>|=").find(descr[0]) == std::string_view::npos) return {};
  for (const Code& code : codes) {
    if (descr.substr(1) != code.text) continue;
    return NpyItem{code.type, code.bytes, descr[0] == '>' && code.bytes > 1};
  }
  return {};
}

float float_of_half(std::uint16_t half) {
  const float sign = (half & 0x8000U) != 0 ? -1.F : 1.F;
  const int exponent = static_cast<int>((half >> 10U) & 0x1FU);
  const auto fraction = static_cast<float>(half & 0x3FFU);
  if (exponent == 0) return sign * std::ldexp(fraction, -24);
  if (exponent < 31) return sign * std::ldexp(1024 + fraction, exponent - 25);
  return fraction == 0 ? sign * std::numeric_limits<float>::infinity()
                       : std::numeric_limits<float>::quiet_NaN();
}

void check_npy_size(const InputFile& file, const NpyHeader& header, std::size_t item_bytes) {
  std::uint64_t wanted = item_bytes;
  for (const std::uint64_t extent : header.shape) {
    if (__builtin_mul_overflow(wanted, extent, &wanted)) {
      file.fail("has the shape " + shape_text(header.shape) + ", which no file can hold");
    }
  }
  if (wanted == header.data_bytes) return;
  file.fail(std::string(wanted > header.data_bytes ? "is truncated" : "is too long") +
            ": its shape " + shape_text(header.shape) + " needs " + std::to_string(wanted) +
            " bytes of data, there are " + std::to_string(header.data_bytes));
}

std::string shape_text(const std::vector<std::uint64_t>& shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i) {
    if (i > 0) text += ", ";
    text += std::to_string(shape[i]);
  }
  return text + (shape.size() == 1 ? ",)" : ")");
}

std::string format_npy_header(std::string_view descr, const std::vector<std::uint64_t>& shape) {
  std::string dictionary = "{'descr': '" + std::string(descr) +
                           "', 'fortran_order': False, 'shape': " + shape_text(shape) + ", }";
  const std::size_t before = kMagic.size() + 4;
  dictionary.append(63 - (before + dictionary.size()) % 64, ' ');
  dictionary += '\n';
  const auto length = static_cast<unsigned>(dictionary.size());
  std::string header(kMagic);
  header += '\x01';
  header += '\0';
  header += static_cast<char>(length & 0xFFU);
  header += static_cast<char>(length >> 8U);
  return header + dictionary;
}

}  // namespace ccvt::io
