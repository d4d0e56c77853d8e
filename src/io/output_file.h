#pragma once

#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <string_view>

namespace ccvt::io {

/// A file that appears under its name only when it is complete: written under
/// temporary_path(target), then renamed. Unless committed, the destructor removes it.
class OutputFile {
 public:
  /// Throws IoError when the file cannot be created.
  explicit OutputFile(std::filesystem::path target);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  /// Throws IoError.
  void write(const void* data, std::size_t count);
  void write(std::string_view text) { write(text.data(), text.size()); }
  /// Flushes, closes and renames. Throws IoError.
  void commit();

 private:
  [[noreturn]] void fail(int error) const;

  std::filesystem::path target_;
  std::filesystem::path temporary_;
  std::FILE* file_ = nullptr;
};

}  // namespace ccvt::io
