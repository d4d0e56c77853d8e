#include "io/ply_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "ccvt/types.h"
#include "io/text.h"

namespace ccvt::io {

namespace {

constexpr std::size_t kLongestLine = 1 << 16;

bool type_named(std::string_view name, PlyType& type) {
  struct Name {
    std::string_view text;
    PlyType type;
  };
  static constexpr std::array<Name, 16> names = {{{"char", PlyType::int8},
                                                  {"int8", PlyType::int8},
                                                  {"uchar", PlyType::uint8},
                                                  {"uint8", PlyType::uint8},
                                                  {"short", PlyType::int16},
                                                  {"int16", PlyType::int16},
                                                  {"ushort", PlyType::uint16},
                                                  {"uint16", PlyType::uint16},
                                                  {"int", PlyType::int32},
                                                  {"int32", PlyType::int32},
                                                  {"uint", PlyType::uint32},
                                                  {"uint32", PlyType::uint32},
                                                  {"float", PlyType::float32},
                                                  {"float32", PlyType::float32},
                                                  {"double", PlyType::float64},
                                                  {"float64", PlyType::float64}}};
  for (const Name& candidate : names) {
    if (candidate.text != name) continue;
    type = candidate.type;
    return true;
  }
  return false;
}

std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  while (true) {
    const auto begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return words;
    line.remove_prefix(begin);
    words.push_back(line.substr(0, line.find_first_of(" \t\r")));
    line.remove_prefix(words.back().size());
  }
}

}  // namespace

std::size_t bytes_of(PlyType type) {
  switch (type) {
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::float64:
      return 8;
    default:
      return 4;
  }
}

PlyFile::PlyFile(const std::filesystem::path& path) : file_(path) { read_header(); }

PlyElement* PlyFile::find(std::string_view name) {
  const auto found = std::find_if(elements_.begin(), elements_.end(),
                                  [name](const PlyElement& e) { return e.name == name; });
  return found == elements_.end() ? nullptr : &*found;
}

void PlyFile::check_count(const PlyElement& element) {
  const std::string many = element.name == "vertex" ? "vertices" : element.name + " items";
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : element.properties) {
    bytes += encoding_ == Encoding::ascii
                 ? 2
                 : bytes_of(property.list ? property.length : property.type);
  }
  if (element.count == 0) file_.fail("has no " + many);
  if (element.count > std::numeric_limits<Index>::max()) {
    file_.fail("has " + std::to_string(element.count) + " " + many +
               "; at most 2147483647 are supported");
  }
  // ascii: a digit and a blank, but for the end of the file.
  if (element.count * bytes > file_.size() + 1) {
    file_.fail("is truncated: " + std::to_string(element.count) + " " + many + " need at least " +
               std::to_string(element.count * bytes) + " bytes, the file has " +
               std::to_string(file_.size()));
  }
}

void PlyFile::skip_to(const PlyElement& element) {
  for (const PlyElement& before : elements_) {
    if (&before == &element) return;
    for (std::uint64_t i = 0; i < before.count; ++i) read_item(before, i, [](int, double) {});
  }
}

void PlyFile::begin_item(const PlyElement& element, std::uint64_t item) {
  place_ = element.name + " " + std::to_string(item);
  if (encoding_ != Encoding::ascii) return;
  do {
    if (!read_line()) file_.fail("is truncated: it ends before " + place_);
    words_ = words_of(line_);
  } while (words_.empty());
  next_ = 0;
}

bool PlyFile::read_line() {
  line_.clear();
  for (char c = 0; file_.read_some(&c, 1) == 1;) {
    if (c == '\n') return true;
    line_ += c;
    if (line_.size() > kLongestLine) file_.fail("has a line of more than 65536 bytes");
  }
  return !line_.empty();
}

void PlyFile::read_header() {
  if (!read_line() || words_of(line_) != std::vector<std::string_view>{"ply"}) {
    file_.fail("does not start with 'ply'");
  }
  bool format = false;
  while (true) {
    if (!read_line()) file_.fail("ends before 'end_header'");
    const auto words = words_of(line_);
    if (words.empty()) continue;
    if (words[0] == "comment" || words[0] == "obj_info") {
      comments_.push_back(line_.substr(0, line_.find_last_not_of('\r') + 1));
      continue;
    }
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      format = words[1] == "ascii" || words[1] == "binary_little_endian" ||
               words[1] == "binary_big_endian";
      if (!format) file_.fail("has the unknown format " + io::quoted(words[1]));
      encoding_ = words[1] == "ascii"                  ? Encoding::ascii
                  : words[1] == "binary_little_endian" ? Encoding::little
                                                       : Encoding::big;
    } else if (words[0] == "element" && words.size() == 3) {
      PlyElement& element = elements_.emplace_back();
      element.name = words[1];
      const char* const end = words[2].data() + words[2].size();
      const auto [stop, error] = std::from_chars(words[2].data(), end, element.count);
      if (error != std::errc() || stop != end) {
        file_.fail("header: " + io::quoted(words[2]) + " is not a number of elements");
      }
    } else if (words[0] == "property" && !elements_.empty()) {
      add_property(words);
    } else {
      file_.fail("header: " + io::quoted(line_) + " is not understood");
    }
  }
  if (!format) file_.fail("header: has no format");
  for (const PlyElement& each : elements_) {
    if (each.properties.empty()) {
      file_.fail("element " + io::quoted(each.name) + " has no properties");
    }
  }
}

void PlyFile::add_property(const std::vector<std::string_view>& words) {
  PlyProperty property;
  property.list = words.size() == 5 && words[1] == "list";
  const bool good = property.list ? type_named(words[2], property.length) &&
                                        property.length < PlyType::float32 &&
                                        type_named(words[3], property.type)
                                  : words.size() == 3 && type_named(words[1], property.type);
  if (!good) file_.fail("header: " + io::quoted(line_) + " is not understood");
  property.name = words.back();
  elements_.back().properties.push_back(std::move(property));
}

std::string_view PlyFile::next_word() {
  if (next_ == words_.size()) file_.fail(place_ + ": has too few numbers");
  if (copy_ != nullptr) {
    *copy_ += words_[next_];
    *copy_ += ' ';
  }
  return words_[next_++];
}

double PlyFile::read_number(PlyType type, bool any) {
  if (encoding_ == Encoding::ascii) {
    double value = 0;
    const std::string_view word = next_word();
    const char* const wrong = parse(word, value);
    if (wrong != nullptr && !(any && !std::isfinite(value)))
      file_.fail(place_ + ": " + io::quoted(word) + " " + wrong);
    return value;
  }
  std::array<char, 8> bytes{};
  const std::size_t size = bytes_of(type);
  file_.read(bytes.data(), size);
  if (copy_ != nullptr) copy_->append(bytes.data(), size);
  static_assert(std::endian::native == std::endian::little);
  if (encoding_ == Encoding::big) {
    std::reverse(bytes.data(), bytes.data() + size);
  }
  const auto as = [&bytes](auto value) {
    std::memcpy(&value, bytes.data(), sizeof value);
    return static_cast<double>(value);
  };
  switch (type) {
    case PlyType::int8:
      return as(std::int8_t{});
    case PlyType::uint8:
      return as(std::uint8_t{});
    case PlyType::int16:
      return as(std::int16_t{});
    case PlyType::uint16:
      return as(std::uint16_t{});
    case PlyType::int32:
      return as(std::int32_t{});
    case PlyType::uint32:
      return as(std::uint32_t{});
    case PlyType::float32:
      return as(float{});
    default:
      return as(double{});
  }
}

void PlyFile::skip_number(PlyType type) {
  if (encoding_ == Encoding::ascii) {
    next_word();
  } else {
    read_number(type);
  }
}

std::uint64_t PlyFile::read_length(PlyType type) {
  const double length = read_number(type);
  if (length < 0 || length != std::floor(length) || length > 4294967295.0) {
    file_.fail(place_ + ": has a list of a length that is no whole number");
  }
  return static_cast<std::uint64_t>(length);
}

}  // namespace ccvt::io
