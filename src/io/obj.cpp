#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "io/lines.h"
#include "io/mesh_file.h"
#include "io/text.h"
#include "number_text.h"

namespace ccvt::io {

namespace {

constexpr std::size_t kLongestStatement = std::size_t{64} << 20;
constexpr std::string_view kBlanks = " \t\r\v\f";

/// Takes the next word from the front of a line; empty at its end.
std::string_view take_word(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(kBlanks), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
  line.remove_prefix(word.size());
  return word;
}

class ObjReader {
 public:
  ObjReader(const std::filesystem::path& path, const std::string& density)
      : lines_(path, "an OBJ file") {
    if (density.empty()) return;
    constexpr std::array<std::string_view, 3> colours = {"red", "green", "blue"};
    const std::ptrdiff_t found =
        std::find(colours.begin(), colours.end(), density) - colours.begin();
    if (found == std::ssize(colours)) {
      lines_.file().fail("has no density " + io::quoted(density) +
                         "; of OBJ files it is red, green or blue");
    }
    density_ = 3 + static_cast<std::size_t>(found);
  }

  MeshParts read() {
    for (std::string_view line; next_statement(line);) {
      const std::string_view keyword = take_word(line);
      if (keyword == "v") add_vertex(line);
      if (keyword == "f") add_face(line);
    }
    if (highest_ >= vertices()) {
      lines_.file().fail(concat("line ", highest_line_, ": a face has vertex ", highest_ + 1,
                                ", but there are ", vertices()));
    }
    if (vertices() == 0) lines_.file().fail("has no vertices");
    if (parts_.corners.empty()) lines_.file().fail("has no faces: it holds no surface");
    return std::move(parts_);
  }

 private:
  [[nodiscard]] std::int64_t vertices() const { return std::ssize(parts_.coordinates) / 3; }

  /// A line, with those that continue it, without its comment.
  bool next_statement(std::string_view& statement) {
    joined_.clear();
    for (std::string_view line; lines_.next(line);) {
      line = line.substr(0, line.find('#'));
      const std::size_t last = line.find_last_not_of(kBlanks);
      const bool goes_on = last != std::string_view::npos && line[last] == '\\';
      if (goes_on) line = line.substr(0, last);
      if (!goes_on && joined_.empty()) {
        statement = line;
        return true;
      }
      joined_ += line;
      joined_ += ' ';
      if (joined_.size() > kLongestStatement) lines_.fail("continues lines of more than 64 MiB");
      if (!goes_on) break;
    }
    statement = joined_;
    return !joined_.empty();
  }

  void add_vertex(std::string_view line) {
    std::array<double, 6> numbers{};
    std::size_t count = 0;
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      if (count < numbers.size()) {
        const char* const wrong = parse(word, numbers[count]);
        if (wrong != nullptr) lines_.fail(quoted(word) + " " + wrong);
      }
      ++count;
    }
    if (count < 3) lines_.fail(concat("a vertex has ", count, " numbers; needs x, y and z"));
    if (vertices() == std::numeric_limits<Index>::max()) {
      lines_.fail("has more than 2147483647 vertices");
    }
    parts_.coordinates.insert(parts_.coordinates.end(), numbers.begin(), numbers.begin() + 3);
    if (density_ == 0) return;
    if (count < numbers.size()) {
      lines_.fail(concat("a vertex has ", count,
                         " numbers; for a density it needs x, y, z, red, green and blue"));
    }
    if (numbers[density_] < 0) {
      lines_.fail(concat("a density is ", numbers[density_], "; must not be negative"));
    }
    parts_.density.push_back(numbers[density_]);
  }

  void add_face(std::string_view line) {
    face_.clear();
    for (std::string_view word = take_word(line); !word.empty(); word = take_word(line)) {
      face_.push_back(corner(word));
    }
    if (face_.size() < 3) {
      lines_.fail(concat("a face has ", face_.size(), " corners; needs at least 3"));
    }
    parts_.add_face(lines_.file(), face_);
  }

  /// The vertex of i, i/j, i//k or i/j/k. It may be defined later.
  Index corner(std::string_view word) {
    const bool known = word.find_first_not_of("+-0123456789/") == std::string_view::npos &&
                       std::count(word.begin(), word.end(), '/') <= 2;
    Index number = 0;
    const char* const wrong = parse(word.substr(0, word.find('/')), number);
    if (!known || wrong != nullptr) {
      lines_.fail(quoted(word) + " is not a corner of a face: i, i/j, i//k or i/j/k");
    }
    const std::int64_t vertex = number > 0 ? std::int64_t{number} - 1 : vertices() + number;
    if (number == 0 || vertex < 0) {
      lines_.fail(concat("a face has vertex ", number, ", but numbers start from 1, or from -1, ",
                         "the last one of the ", vertices(), " so far"));
    }
    if (vertex > highest_) {
      highest_ = vertex;
      highest_line_ = lines_.number();
    }
    return static_cast<Index>(vertex);
  }

  Lines lines_;
  std::size_t density_ = 0;  // which number of a vertex; 0: none
  MeshParts parts_;
  std::string joined_;
  std::vector<Index> face_;
  std::int64_t highest_ = -1;
  std::uint64_t highest_line_ = 0;
};

}  // namespace

MeshParts read_obj(const std::filesystem::path& path, const std::string& density) {
  return ObjReader(path, density).read();
}

}  // namespace ccvt::io
