#include "io/ply.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "io/columns.h"
#include "io/input_file.h"
#include "io/points_map.h"
#include "io/text.h"

namespace ccvt::io {

namespace {

constexpr std::size_t kLongestLine = 1 << 16;

enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property {
  Type type = Type::float32;
  bool list = false;
  Type length = Type::uint8;  ///< of a list
  std::string name;
  int axis = -1;  ///< of a vertex: which coordinate of the point
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

enum class Encoding { ascii, little, big };

std::size_t bytes_of(Type type) {
  switch (type) {
    case Type::int8:
    case Type::uint8:
      return 1;
    case Type::int16:
    case Type::uint16:
      return 2;
    case Type::float64:
      return 8;
    default:
      return 4;
  }
}

bool type_named(std::string_view name, Type& type) {
  struct Name {
    std::string_view text;
    Type type;
  };
  static constexpr std::array<Name, 16> names = {{{"char", Type::int8},
                                                  {"int8", Type::int8},
                                                  {"uchar", Type::uint8},
                                                  {"uint8", Type::uint8},
                                                  {"short", Type::int16},
                                                  {"int16", Type::int16},
                                                  {"ushort", Type::uint16},
                                                  {"uint16", Type::uint16},
                                                  {"int", Type::int32},
                                                  {"int32", Type::int32},
                                                  {"uint", Type::uint32},
                                                  {"uint32", Type::uint32},
                                                  {"float", Type::float32},
                                                  {"float32", Type::float32},
                                                  {"double", Type::float64},
                                                  {"float64", Type::float64}}};
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

/// The file from its header on.
class PlyFile {
 public:
  PlyFile(const std::filesystem::path& path, const ReadOptions& options)
      : file_(path), wanted_(options.columns) {
    read_header();
  }

  [[nodiscard]] PointsHeader points_header() const {
    PointsHeader header;
    header.scalar = ScalarType::float32;
    for (const Property& property : vertices().properties) {
      if (property.axis < 0) continue;
      ++header.dimension;
      if (property.type != Type::float32) header.scalar = ScalarType::float64;
    }
    header.count = vertices().count;
    return header;
  }

  template <class Scalar>
  void read(const detail::Allocation<Scalar>& allocation) {
    const PointsHeader header = points_header();
    for (const Element& element : elements_) {
      if (&element == &vertices()) break;
      for (std::uint64_t i = 0; i < element.count; ++i) read_item(element, i, [](int, double) {});
    }
    PointsMap<Scalar> points = allocate(allocation, header);
    Scalar* vertex = points.data();
    for (std::uint64_t i = 0; i < header.count; ++i) {
      read_item(vertices(), i, [&](int axis, double value) {
        const auto x = static_cast<Scalar>(value);
        if (!std::isfinite(x)) {
          std::string text;
          append(text, value);
          file_.fail("vertex " + std::to_string(i) + ": " + name_of(axis) + " is " + text +
                     (std::isfinite(value) ? ", out of the range of float32"
                                           : "; coordinates must be finite"));
        }
        vertex[axis] = x;
      });
      vertex += header.dimension;
    }
  }

 private:
  [[nodiscard]] const Element& vertices() const { return elements_[vertex_]; }

  void read_header();
  void add_property(const std::vector<std::string_view>& words);
  void check_vertices();
  void choose_axes(Element& element) const;
  [[nodiscard]] const std::string& name_of(int axis) const;
  /// A line without its end; false at the end of the file.
  bool read_line();
  std::string_view next_word();
  double read_number(Type type);
  void skip_number(Type type);
  std::uint64_t read_length(Type type);
  template <class Visit>
  void read_item(const Element& element, std::uint64_t item, Visit visit);

  InputFile file_;
  std::vector<std::string> wanted_;  ///< columns; empty: x, y and z
  Encoding encoding_ = Encoding::ascii;
  std::vector<Element> elements_;
  std::size_t vertex_ = 0;
  std::string line_;
  std::vector<std::string_view> words_;  ///< of line_
  std::size_t next_ = 0;
  std::string place_;  ///< for messages
};

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
    if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
    if (words[0] == "end_header") break;
    if (words[0] == "format" && words.size() == 3) {
      format = words[1] == "ascii" || words[1] == "binary_little_endian" ||
               words[1] == "binary_big_endian";
      if (!format) file_.fail("has the unknown format " + io::quoted(words[1]));
      encoding_ = words[1] == "ascii"                  ? Encoding::ascii
                  : words[1] == "binary_little_endian" ? Encoding::little
                                                       : Encoding::big;
    } else if (words[0] == "element" && words.size() == 3) {
      Element& element = elements_.emplace_back();
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
  check_vertices();
}

void PlyFile::add_property(const std::vector<std::string_view>& words) {
  Property property;
  property.list = words.size() == 5 && words[1] == "list";
  const bool good = property.list
                        ? type_named(words[2], property.length) &&
                              property.length < Type::float32 && type_named(words[3], property.type)
                        : words.size() == 3 && type_named(words[1], property.type);
  if (!good) file_.fail("header: " + io::quoted(line_) + " is not understood");
  property.name = words.back();
  elements_.back().properties.push_back(std::move(property));
}

/// Gives the properties that are coordinates their axes.
void PlyFile::choose_axes(Element& element) const {
  std::vector<std::string> names;
  std::vector<Property*> properties;
  for (Property& property : element.properties) {
    if (property.list) continue;
    names.push_back(property.name);
    properties.push_back(&property);
  }
  std::vector<std::string> wanted = wanted_;
  if (wanted.empty()) {
    std::array<std::ptrdiff_t, 3> given{};
    for (std::size_t d = 0; d < 3; ++d) {
      given[d] = std::count(names.begin(), names.end(), std::string(1, "xyz"[d]));
    }
    if (given[0] != 1 || given[1] != 1 || given[2] > 1) {
      file_.fail("vertices need one x and one y, and at most one z");
    }
    wanted = {"x", "y", "z"};
    wanted.resize(given[2] == 1 ? 3 : 2);
  }
  const TableColumns columns = choose_columns(file_, wanted, names, names.size());
  int axis = 0;
  for (const std::size_t at : columns.at) properties[at]->axis = axis++;
}

const std::string& PlyFile::name_of(int axis) const {
  return std::find_if(vertices().properties.begin(), vertices().properties.end(),
                      [&](const Property& property) { return property.axis == axis; })
      ->name;
}

void PlyFile::check_vertices() {
  for (const Element& element : elements_) {
    if (element.properties.empty()) {
      file_.fail("element " + io::quoted(element.name) + " has no properties");
    }
  }
  const auto found = std::find_if(elements_.begin(), elements_.end(),
                                  [](const Element& e) { return e.name == "vertex"; });
  if (found == elements_.end()) file_.fail("has no element 'vertex'");
  vertex_ = static_cast<std::size_t>(found - elements_.begin());
  choose_axes(*found);
  std::uint64_t bytes = 0;
  for (const Property& property : found->properties) {
    bytes += encoding_ == Encoding::ascii
                 ? 2
                 : bytes_of(property.list ? property.length : property.type);
  }
  if (found->count == 0) file_.fail("has no vertices");
  if (found->count > std::numeric_limits<Index>::max()) {
    file_.fail("has " + std::to_string(found->count) +
               " vertices; at most 2147483647 are supported");
  }
  // Before anything is allocated; ascii: a digit and a blank, but for the end of the file.
  if (found->count * bytes > file_.size() + 1) {
    file_.fail("is truncated: " + std::to_string(found->count) + " vertices need at least " +
               std::to_string(found->count * bytes) + " bytes, the file has " +
               std::to_string(file_.size()));
  }
}

std::string_view PlyFile::next_word() {
  if (next_ == words_.size()) file_.fail(place_ + ": has too few numbers");
  return words_[next_++];
}

double PlyFile::read_number(Type type) {
  if (encoding_ == Encoding::ascii) {
    double value = 0;
    const std::string_view word = next_word();
    const char* const wrong = parse(word, value);
    if (wrong != nullptr) file_.fail(place_ + ": " + io::quoted(word) + " " + wrong);
    return value;
  }
  std::array<char, 8> bytes{};
  const std::size_t size = bytes_of(type);
  file_.read(bytes.data(), size);
  static_assert(std::endian::native == std::endian::little);
  if (encoding_ == Encoding::big) {
    std::reverse(bytes.data(), bytes.data() + size);
  }
  const auto as = [&bytes](auto value) {
    std::memcpy(&value, bytes.data(), sizeof value);
    return static_cast<double>(value);
  };
  switch (type) {
    case Type::int8:
      return as(std::int8_t{});
    case Type::uint8:
      return as(std::uint8_t{});
    case Type::int16:
      return as(std::int16_t{});
    case Type::uint16:
      return as(std::uint16_t{});
    case Type::int32:
      return as(std::int32_t{});
    case Type::uint32:
      return as(std::uint32_t{});
    case Type::float32:
      return as(float{});
    default:
      return as(double{});
  }
}

void PlyFile::skip_number(Type type) {
  if (encoding_ == Encoding::ascii) {
    next_word();
  } else {
    read_number(type);
  }
}

std::uint64_t PlyFile::read_length(Type type) {
  const double length = read_number(type);
  if (length < 0 || length != std::floor(length) || length > 4294967295.0) {
    file_.fail(place_ + ": has a list of a length that is no whole number");
  }
  return static_cast<std::uint64_t>(length);
}

template <class Visit>
void PlyFile::read_item(const Element& element, std::uint64_t item, Visit visit) {
  place_ = element.name + " " + std::to_string(item);
  if (encoding_ == Encoding::ascii) {
    do {
      if (!read_line()) file_.fail("is truncated: it ends before " + place_);
      words_ = words_of(line_);
    } while (words_.empty());
    next_ = 0;
  }
  for (const Property& property : element.properties) {
    const std::uint64_t count = property.list ? read_length(property.length) : 1;
    for (std::uint64_t i = 0; i < count; ++i) {
      if (property.axis >= 0) {
        visit(property.axis, read_number(property.type));
      } else {
        skip_number(property.type);
      }
    }
  }
}

}  // namespace

PointsHeader inspect_ply_points(const std::filesystem::path& path, const ReadOptions& options) {
  return PlyFile(path, options).points_header();
}

template <class Scalar>
void read_ply_points(const std::filesystem::path& path, const ReadOptions& options,
                     const detail::Allocation<Scalar>& allocation) {
  PlyFile(path, options).read(allocation);
}

template void read_ply_points(const std::filesystem::path&, const ReadOptions&,
                              const detail::Allocation<float>&);
template void read_ply_points(const std::filesystem::path&, const ReadOptions&,
                              const detail::Allocation<double>&);

}  // namespace ccvt::io
