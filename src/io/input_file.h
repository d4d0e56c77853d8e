#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace ccvt::io {

/// `text` in quotes, fit for a one-line message: shortened, unprintable bytes replaced.
std::string quoted(std::string_view text);

/// A regular file, open for reading.
class InputFile {
 public:
  /// Throws InvalidInput when it does not exist, is not a regular file or is empty; IoError when
  /// the system refuses to open it.
  explicit InputFile(const std::filesystem::path& path);

  [[nodiscard]] std::uint64_t size() const { return size_; }
  /// The next bytes, at most `count`; fewer only at the end. Throws IoError.
  std::size_t read_some(void* data, std::size_t count);
  /// Moves on by `count` bytes, past the end too. Throws IoError.
  void skip(std::uint64_t count);
  /// To the byte of this number, from 0. Throws IoError.
  void go_to(std::uint64_t position);
  /// Exactly `count` bytes; throws InvalidInput when the file ends before.
  void read(void* data, std::size_t count);

  /// Throws InvalidInput(path: message).
  [[noreturn]] void fail(const std::string& message) const;

 private:
  void move(std::uint64_t count, int from);

  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string name_;
  std::uint64_t size_ = 0;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace ccvt::io
