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
/// nothing. Where tabs part what a header calls the columns, they part rows of as many fields too.
class TextRows {
 public:
  explicit TextRows(const std::filesystem::path& path);

  /// Advances to the next row; false at the end.
  bool next();
  /// The fields of the row, valid until the next call of next(). Never empty.
  [[nodiscard]] const std::vector<std::string_view>& fields() const { return fields_; }
  /// The same with the quotes that they stand between.
  [[nodiscard]] const std::vector<std::string_view>& texts() const { return texts_; }
  /// What the header calls the columns of the row; empty where there is none, or a title in its
  /// place. Throws InvalidInput where it names more or fewer.
  [[nodiscard]] std::vector<std::string> names() const;
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
  void check_returns(std::string_view line) const;
  [[nodiscard]] char separator_of_next(std::string_view line) const;
  /// Fills fields_ and texts_ from a line that is not blank.
  void split(std::string_view line, char separator);

  Lines lines_;
  bool first_ = true;
  char separator_ = ' ';  ///< of the last line
  std::vector<std::string_view> fields_;
  std::vector<std::string_view> texts_;
  std::vector<std::string> names_;
  char names_separator_ = ' ';
  std::uint64_t names_line_ = 0;
};

/// Appends the text of a field, put between quotes where that separator, ',' or ' ', would not
/// leave it whole.
void append_field(std::string& text, std::string_view field, char separator);

/// The value of a whole field. Sets it and returns nullptr, or returns what is wrong with it.
const char* parse(std::string_view field, float& value);
const char* parse(std::string_view field, double& value);
const char* parse(std::string_view field, std::int32_t& value);

/// Appends the shortest text that reads back as the same value.
void append(std::string& text, float value);
void append(std::string& text, double value);
void append(std::string& text, std::int32_t value);

}  // namespace ccvt::io
