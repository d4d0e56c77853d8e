#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/lines.h"

namespace ccvt::io {

/// The rows of fields of a text file, without comments, blank lines and the header. Fields are
/// parted by commas, or semicolons, or blanks, and may stand between quotes, where these part
/// nothing.
class TextRows {
 public:
  explicit TextRows(const std::filesystem::path& path);

  /// Advances to the next row; false at the end.
  bool next();
  /// The fields of the row, valid until the next call of next(). Never empty.
  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  /// What the header calls the columns; empty where there is none. After next().
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// 1-based number of the line that the row is on.
  [[nodiscard]] std::uint64_t line() const { return lines_.number(); }
  /// Counts the lines left in the file, by their ends; next() is then of no use any more.
  std::uint64_t count_lines() { return lines_.count_left(); }

  /// Throws InvalidInput(path: line N: message).
  [[noreturn]] void fail(const std::string& message) const { lines_.fail(message); }
  /// The same of the field at a place of the row, from 0, that parse() finds something wrong with.
  [[noreturn]] void fail_field(std::size_t at, const char* wrong) const;
  /// Throws InvalidInput(path: message).
  [[noreturn]] void fail_file(const std::string& message) const { file().fail(message); }
  [[nodiscard]] const InputFile& file() const { return lines_.file(); }

 private:
  /// Fills fields_.
  void split(std::string_view line);

  Lines lines_;
  bool first_ = true;
  char separator_ = ' ';  ///< of the last line
  std::vector<std::string_view> fields_;
  std::vector<std::string> names_;
};

/// The value of a whole field. Sets it and returns nullptr, or returns what is wrong with it.
const char* parse(std::string_view field, float& value);
const char* parse(std::string_view field, double& value);
const char* parse(std::string_view field, std::int32_t& value);

/// Appends the shortest text that reads back as the same value.
void append(std::string& text, float value);
void append(std::string& text, double value);
void append(std::string& text, std::int32_t value);

}  // namespace ccvt::io
