#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/input_file.h"

namespace ccvt::io {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

std::size_t bytes_of(PlyType type);

struct PlyProperty {
  PlyType type = PlyType::float32;
  bool list = false;
  PlyType length = PlyType::uint8;  ///< of a list
  std::string name;
  int slot = -1;     ///< what its values are handed out under; below 0: they are skipped
  bool any = false;  ///< those that are not finite are handed out too, in ascii as well
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

/// A PLY file, ascii or binary of either byte order: its header, and then its items one by one.
/// Everything throws InvalidInput with the file's name and the place; items count from 0.
class PlyFile {
 public:
  enum class Encoding { ascii, little, big };

  /// Reads the header. Whoever wants values gives their properties slots.
  explicit PlyFile(const std::filesystem::path& path);

  [[nodiscard]] InputFile& file() { return file_; }
  [[nodiscard]] Encoding encoding() const { return encoding_; }
  [[nodiscard]] std::vector<PlyElement>& elements() { return elements_; }
  [[nodiscard]] const std::vector<PlyElement>& elements() const { return elements_; }
  /// Lines such as "comment ..." and "obj_info ...", as they are.
  [[nodiscard]] const std::vector<std::string>& comments() const { return comments_; }
  /// The one of that name; null where there is none.
  [[nodiscard]] PlyElement* find(std::string_view name);
  /// Throws unless the file can hold as many items as `element` has, of at least one item and fewer
  /// than 2^31: before anything is allocated for them.
  void check_count(const PlyElement& element);

  /// Reads the next item, the `item`th of `element`, and calls visit(slot, value) for each value
  /// that has a slot, in the file's order; of a list for all of its values.
  template <class Visit>
  void read_item(const PlyElement& element, std::uint64_t item, Visit visit) {
    begin_item(element, item);
    for (const PlyProperty& property : element.properties) {
      const std::uint64_t count = property.list ? read_length(property.length) : 1;
      for (std::uint64_t i = 0; i < count; ++i) {
        if (property.slot >= 0) {
          visit(property.slot, read_number(property.type, property.any));
        } else {
          skip_number(property.type);
        }
      }
    }
  }
  /// From now on what is read of items is appended there too, as it is encoded; of ascii the words,
  /// with a blank after each.
  void copy_to(std::string* bytes) { copy_ = bytes; }
  /// Skips all items of the elements before `element`.
  void skip_to(const PlyElement& element);

 private:
  void read_header();
  void add_property(const std::vector<std::string_view>& words);
  /// A line without its end; false at the end of the file.
  bool read_line();
  void begin_item(const PlyElement& element, std::uint64_t item);
  std::string_view next_word();
  double read_number(PlyType type, bool any = false);
  void skip_number(PlyType type);
  std::uint64_t read_length(PlyType type);

  InputFile file_;
  Encoding encoding_ = Encoding::ascii;
  std::vector<PlyElement> elements_;
  std::vector<std::string> comments_;
  std::string line_;
  std::vector<std::string_view> words_;  ///< of line_
  std::size_t next_ = 0;
  std::string* copy_ = nullptr;
  std::string place_;  ///< for messages
};

}  // namespace ccvt::io
