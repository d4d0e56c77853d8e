#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "io/input_file.h"

namespace ccvt::io {

/// The lines of a text file, of up to 64 MiB each.
class Lines {
 public:
  /// `kind`: what the file is to be, such as "a table of numbers", for messages.
  Lines(const std::filesystem::path& path, std::string kind);

  /// Gives the next line, without its line feed, valid until the next call; false at the end.
  bool next(std::string_view& line);
  /// The number of that line, from 1.
  [[nodiscard]] std::uint64_t number() const { return number_; }
  /// Counts the lines left in the file, by their ends; next() is then of no use any more.
  std::uint64_t count_left();

  /// Throws InvalidInput(path: line N: message).
  [[noreturn]] void fail(const std::string& message) const;
  [[nodiscard]] const InputFile& file() const { return file_; }

 private:
  InputFile file_;
  std::string kind_;
  std::vector<char> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t number_ = 0;
};

}  // namespace ccvt::io
