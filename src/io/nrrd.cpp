#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "io/formats.h"
#include "io/text.h"
#include "io/volume_file.h"

namespace ccvt::io {

namespace {

constexpr std::size_t kLongestHeader = std::size_t{1} << 16;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// The words of a value; a vector in brackets, blanks included, is one.
std::vector<std::string_view> words(std::string_view text) {
  std::vector<std::string_view> result;
  while (!(text = trimmed(text)).empty()) {
    std::size_t end = text.front() == '(' ? text.find(')') : text.find_first_of(" \t");
    if (end == std::string_view::npos) {
      end = text.size();
    } else if (text.front() == '(') {
      ++end;
    }
    result.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return result;
}

/// The header of an NRRD file: "field: value" lines up to a blank line or the end of the file.
class Header {
 public:
  explicit Header(InputFile& file) : file_(file) {
    std::string line;
    if (!next_line(line) || line.substr(0, 7) != "NRRD000" || line.size() != 8 || line[7] < '1' ||
        line[7] > '5') {
      file.fail("is not an NRRD file: it does not start with NRRD0001 to NRRD0005");
    }
    while (next_line(line)) {
      if (line.empty()) return;
      ++line_;
      if (line.front() == '#') continue;
      const std::size_t colon = line.find(':');
      if (colon == std::string::npos) fail("is not of the form 'field: value'");
      const std::string field = in_lower_case(trimmed(std::string_view(line).substr(0, colon)));
      const std::size_t sign = line.find(":=");
      // A key and value of the user's, whose key may have colons.
      if (sign == colon || (sign != std::string::npos && !is_known(field))) continue;
      if (!is_known(field)) fail("has the unknown field " + io::quoted(field));
      if (!fields_.emplace(field, trimmed(std::string_view(line).substr(colon + 1))).second) {
        fail("gives the field " + io::quoted(field) + " a second time");
      }
    }
    complete_ = false;
  }

  /// Whether a blank line ends the header; else the file does, so the data are elsewhere.
  [[nodiscard]] bool ended() const { return complete_; }
  /// Bytes up to the data.
  [[nodiscard]] std::uint64_t size() const { return size_; }

  /// The value of a field by either of its names; empty if it is not there. Lives as long as this.
  [[nodiscard]] const std::string& value(const std::string& field,
                                         const std::string& other = "") const {
    static const std::string none;
    auto found = fields_.find(field);
    if (found == fields_.end()) found = fields_.find(other);
    return found == fields_.end() ? none : found->second;
  }
  [[nodiscard]] const std::string& required(const std::string& field) const {
    const std::string& result = value(field);
    if (result.empty()) file_.fail("has no field " + io::quoted(field) + " in its header");
    return result;
  }

  [[nodiscard]] std::int64_t whole(const std::string& field, std::string_view word) const {
    std::int64_t value = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size()) {
      file_.fail("field " + io::quoted(field) + ": " + io::quoted(word) +
                 " is not a whole number of at most 64 bits");
    }
    return value;
  }
  [[nodiscard]] double number(const std::string& field, std::string_view word) const {
    double value = 0;
    const char* const wrong = parse(word, value);
    if (wrong != nullptr)
      file_.fail("field " + io::quoted(field) + ": " + io::quoted(word) + " " + wrong);
    return value;
  }
  /// "(1,0,0)"
  [[nodiscard]] Eigen::Vector3d vector(const std::string& field, std::string_view word) const {
    Eigen::Vector3d result;
    if (word.size() < 2 || word.front() != '(' || word.back() != ')') bad_vector(field, word);
    std::string_view rest = word.substr(1, word.size() - 2);
    for (int d = 0; d < 3; ++d) {
      const std::size_t comma = rest.find(',');
      if ((comma == std::string_view::npos) != (d == 2)) bad_vector(field, word);
      result[d] = number(field, trimmed(rest.substr(0, comma)));
      rest.remove_prefix(d == 2 ? 0 : comma + 1);
    }
    return result;
  }
  [[nodiscard]] std::vector<std::string_view> three(const std::string& field,
                                                    std::string_view value) const {
    std::vector<std::string_view> result = words(value);
    if (result.size() != 3) {
      file_.fail("field " + io::quoted(field) + " has " + std::to_string(result.size()) +
                 " entries; 3 are needed, one for each dimension");
    }
    return result;
  }

 private:
  [[noreturn]] void fail(const std::string& message) const {
    file_.fail("line " + std::to_string(line_) + " of its header " + message);
  }
  [[noreturn]] void bad_vector(const std::string& field, std::string_view word) const {
    file_.fail("field " + io::quoted(field) + ": " + io::quoted(word) +
               " is not a vector of 3 numbers");
  }

  static bool is_known(const std::string& field) {
    static const std::set<std::string> known = {"dimension",
                                                "type",
                                                "block size",
                                                "blocksize",
                                                "encoding",
                                                "endian",
                                                "content",
                                                "min",
                                                "max",
                                                "old min",
                                                "oldmin",
                                                "old max",
                                                "oldmax",
                                                "data file",
                                                "datafile",
                                                "line skip",
                                                "lineskip",
                                                "byte skip",
                                                "byteskip",
                                                "number",
                                                "sample units",
                                                "sampleunits",
                                                "sizes",
                                                "spacings",
                                                "thicknesses",
                                                "axis mins",
                                                "axismins",
                                                "axis maxs",
                                                "axismaxs",
                                                "centers",
                                                "centerings",
                                                "labels",
                                                "units",
                                                "kinds",
                                                "space",
                                                "space dimension",
                                                "space units",
                                                "space origin",
                                                "space directions",
                                                "measurement frame"};
    return known.contains(field);
  }

  /// Without its end; false at the end of the file.
  bool next_line(std::string& line) {
    line.clear();
    char c = 0;
    bool any = false;
    while (file_.read_some(&c, 1) == 1) {
      any = true;
      if (++size_ > kLongestHeader) file_.fail("has a header of more than 65536 bytes");
      if (c == '\n') break;
      line += c;
    }
    if (!line.empty() && line.back() == '\r') line.pop_back();
    return any;
  }

  InputFile& file_;
  std::map<std::string, std::string> fields_;
  std::uint64_t size_ = 0;
  int line_ = 1;
  bool complete_ = true;
};

VoxelType type_of(const InputFile& file, const std::string& name) {
  static const std::map<std::string, VoxelType> types = {
      {"signed char", VoxelType::int8},
      {"int8", VoxelType::int8},
      {"int8_t", VoxelType::int8},
      {"uchar", VoxelType::uint8},
      {"unsigned char", VoxelType::uint8},
      {"uint8", VoxelType::uint8},
      {"uint8_t", VoxelType::uint8},
      {"short", VoxelType::int16},
      {"short int", VoxelType::int16},
      {"signed short", VoxelType::int16},
      {"signed short int", VoxelType::int16},
      {"int16", VoxelType::int16},
      {"int16_t", VoxelType::int16},
      {"ushort", VoxelType::uint16},
      {"unsigned short", VoxelType::uint16},
      {"unsigned short int", VoxelType::uint16},
      {"uint16", VoxelType::uint16},
      {"uint16_t", VoxelType::uint16},
      {"int", VoxelType::int32},
      {"signed int", VoxelType::int32},
      {"int32", VoxelType::int32},
      {"int32_t", VoxelType::int32},
      {"uint", VoxelType::uint32},
      {"unsigned int", VoxelType::uint32},
      {"uint32", VoxelType::uint32},
      {"uint32_t", VoxelType::uint32},
      {"longlong", VoxelType::int64},
      {"long long", VoxelType::int64},
      {"long long int", VoxelType::int64},
      {"signed long long", VoxelType::int64},
      {"signed long long int", VoxelType::int64},
      {"int64", VoxelType::int64},
      {"int64_t", VoxelType::int64},
      {"ulonglong", VoxelType::uint64},
      {"unsigned long long", VoxelType::uint64},
      {"unsigned long long int", VoxelType::uint64},
      {"uint64", VoxelType::uint64},
      {"uint64_t", VoxelType::uint64},
      {"float", VoxelType::float32},
      {"double", VoxelType::float64}};
  const auto found = types.find(in_lower_case(name));
  if (found == types.end()) {
    file.fail("has values of type " + io::quoted(name) +
              "; whole numbers and floats of 8 to 64 bits can be read");
  }
  return found->second;
}

void check_dimension(const InputFile& file, const Header& header) {
  const std::int64_t dimension = header.whole("dimension", header.required("dimension"));
  if (dimension == 3) return;
  file.fail("has " + std::to_string(dimension) + " dimensions; a volume needs 3" +
            (dimension > 3 ? ": colours, vectors and series are not read" : ""));
}

void check_kinds(const InputFile& file, const Header& header) {
  const std::string& kinds = header.value("kinds");
  if (kinds.empty()) return;
  for (const std::string_view kind : header.three("kinds", kinds)) {
    const std::string name = in_lower_case(kind);
    if (name == "domain" || name == "space" || name == "none" || name == "???") continue;
    file.fail("has an axis of kind " + io::quoted(kind) +
              "; three axes of kind 'domain' or 'space' are needed");
  }
}

void place(const InputFile& file, const Header& header, Grid& grid) {
  grid.axes = Eigen::Matrix3d::Identity();
  grid.origin = Eigen::Vector3d::Zero();
  const std::string& directions = header.value("space directions");
  const std::string& spacings = header.value("spacings");
  if (!directions.empty()) {
    const auto columns = header.three("space directions", directions);
    Eigen::Index d = 0;
    for (const std::string_view column : columns) {
      grid.axes.eigen().col(d) = header.vector("space directions", column);
      ++d;
    }
  } else if (!spacings.empty()) {
    const auto entries = header.three("spacings", spacings);
    Eigen::Index d = 0;
    for (const std::string_view entry : entries) {
      const double spacing = header.number("spacings", entry);
      if (spacing == 0) file.fail("field 'spacings': is 0; spacings must not be");
      grid.axes(d, d) = spacing;
      ++d;
    }
  } else if (!header.value("axis mins", "axismins").empty() ||
             !header.value("axis maxs", "axismaxs").empty()) {
    file.fail(
        "places its axes by 'axis mins' and 'axis maxs'; give 'spacings' or "
        "'space directions' instead");
  }
  const std::string& origin = header.value("space origin");
  if (!origin.empty()) {
    grid.origin = header.vector("space origin", origin);
  } else if (const std::string& mins = header.value("axis mins", "axismins"); !mins.empty()) {
    for (const std::string_view entry : header.three("axis mins", mins)) {
      if (entry == "nan" || entry == "NaN" || header.number("axis mins", entry) == 0) continue;
      file.fail("field 'axis mins': " + io::quoted(entry) +
                " may be a border of cells or the middle of one; give 'space origin' instead");
    }
  }
}

}  // namespace

VolumeFile open_nrrd(const std::filesystem::path& path) {
  InputFile file(path);
  const Header header(file);
  VolumeFile result;

  check_dimension(file, header);
  result.header.type = type_of(file, header.required("type"));
  for (const std::string_view word : header.three("sizes", header.required("sizes"))) {
    result.header.grid.shape.push_back(header.whole("sizes", word));
  }
  check_kinds(file, header);
  place(file, header, result.header.grid);

  const std::string encoding = in_lower_case(header.required("encoding"));
  result.gzip = encoding == "gzip" || encoding == "gz";
  if (!result.gzip && encoding != "raw") {
    file.fail("has the encoding " + io::quoted(encoding) + "; raw and gzip can be read");
  }
  const std::string endian = in_lower_case(header.value("endian"));
  if (bytes_of(result.header.type) > 1 && endian != "little" && endian != "big") {
    file.fail(endian.empty() ? std::string("has no field 'endian' in its header")
                             : "has the byte order " + io::quoted(endian) + ", not little or big");
  }
  result.big_endian = endian == "big";

  const std::string& lines = header.value("line skip", "lineskip");
  if (!lines.empty() && header.whole("line skip", lines) != 0) {
    file.fail("has a 'line skip', which is not supported; give a 'byte skip' instead");
  }
  const std::string& bytes = header.value("byte skip", "byteskip");
  const std::int64_t skip = bytes.empty() ? 0 : header.whole("byte skip", bytes);
  result.at_end = skip == -1;
  if (skip < -1 || (skip == -1 && result.gzip)) {
    file.fail("has the byte skip " + std::to_string(skip) +
              "; must be at least 0, or -1 for data that are raw");
  }
  result.skip = static_cast<std::uint64_t>(std::max<std::int64_t>(skip, 0));

  const std::string& data = header.value("data file", "datafile");
  if (data.empty()) {
    if (!header.ended()) file.fail("has no data: its header names no data file, and ends the file");
    result.data = path;
    result.begin = header.size();
  } else if (data.find('%') != std::string::npos || data.substr(0, 4) == "LIST") {
    file.fail("has its data in several files; join them into one first");
  } else {
    result.data = path.parent_path() / data;  // an absolute one stays as it is
  }
  check_volume(file, result.header);
  return result;
}

}  // namespace ccvt::io
